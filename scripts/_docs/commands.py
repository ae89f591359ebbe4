"""The command reference: what `--help` of every command says."""

import argparse
import os
from collections.abc import Iterator

from tp_jax.cli import build_parser

WIDTH = "92"

#: Command to lines that can be typed.
EXAMPLES = {
    "simulate": (
        "tp-jax simulate --preset bench --out run.csv --plot run.png",
        "tp-jax simulate --preset paper-5.1 --set omega=2.1 --duration 60 --plot slips.png",
        "tp-jax simulate --preset bench --single --phi1 0.4 --duration 3 --out column.csv",
    ),
    "record": (
        "tp-jax record --port emulator --duration 10 --omega 13.09 --out run-13.csv",
        "tp-jax record --port emulator --duration 10 --omega 17 --campaign my-rig",
    ),
    "explore": (
        "tp-jax explore --port emulator --speed max --rate 250 --campaign my-rig --limit 1.5",
        "tp-jax explore --port /dev/ttyACM0 --campaign my-rig --omega 5:20 --runs 6",
    ),
    "init": ("tp-jax init my-rig",),
    "check": (
        "tp-jax check my-rig --figure check.png",
        "tp-jax check run-13.csv --omega 13.09",
    ),
    "identify": (
        "tp-jax identify my-rig --json fit.json",
        "tp-jax identify my-rig --starts 16 --fix k=0.45 --bound c1=0:0.01",
    ),
    "sensitivity": ("tp-jax sensitivity my-rig --out what-it-tells",),
    "diagnose": (
        "tp-jax diagnose                  # the example that comes with the package",
        "tp-jax diagnose my-rig --out first --seed 1",
        "tp-jax diagnose rigs/* --out fleet --workers 8 --resume",
    ),
    "compare": ("tp-jax compare before-repair after-repair --html repair.html",),
    "predict": (
        "tp-jax predict first/diagnosis.json --omega 15 --duration 10 --rate 250 --out run-15.csv",
        "tp-jax predict first/diagnosis.json --recording my-rig/run-13.csv --model before",
    ),
    "effects": ("tp-jax effects", "tp-jax effects contact_stribeck"),
    "serve": ("tp-jax serve my-rig", "tp-jax serve --no-browser --port 8000"),
}


def reference() -> str:
    """Markdown, a section for each command."""
    os.environ["COLUMNS"] = WIDTH  # argparse asks for the terminal's width here first
    parts = []
    for parser in _commands(build_parser()):
        parts.append(f"## {parser.prog}\n\n```text\n{parser.format_help().rstrip()}\n```\n")
        lines = EXAMPLES.get(parser.prog.removeprefix("tp-jax").strip())
        if lines:
            parts.append("```sh\n" + "\n".join(lines) + "\n```\n")
    return "\n".join(parts)


def _commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parser itself and all below it, in the order in which help lists them."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for listed in action._choices_actions:
                yield from _commands(action.choices[listed.dest])
