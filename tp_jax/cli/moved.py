"""Commands that have left the package for the repository: each says where it is now."""

import argparse

from tp_jax.errors import InputError

NOT_TYPED = "\0"
"""Takes the place of the dash, so that no word on the line is an option and all reach `run`."""

BLIND = (
    "Sealed trials are not part of the installed package any more; in a clone of the repository "
    "they are ./scripts/blind make, ./scripts/blind score and ./scripts/blind run."
)


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    """Adds `blind`, which the help does not list."""
    parser = subparsers.add_parser("blind", add_help=False, prefix_chars=NOT_TYPED)
    parser.add_argument("words", nargs="*")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:  # noqa: ARG001
    raise InputError(BLIND)
