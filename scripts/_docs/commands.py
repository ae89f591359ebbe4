"""The command reference: what `--help` of every command says."""

import argparse
import os
from collections.abc import Iterator

from tp_jax.cli import build_parser

WIDTH = "92"


def reference() -> str:
    """Markdown, a section for each command."""
    os.environ["COLUMNS"] = WIDTH  # argparse asks for the terminal's width here first
    parts = []
    for parser in _commands(build_parser()):
        parts.append(f"## {parser.prog}\n\n```text\n{parser.format_help().rstrip()}\n```\n")
    return "\n".join(parts)


def _commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parser itself and all below it, in the order in which help lists them."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _commands(below)
