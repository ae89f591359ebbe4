"""scripts/shared_trial: looks at fleets of virtual rigs, or counts what was seen."""

import argparse
import functools
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from scripts._ledger import add_ledger, entries, extended
from tp_jax.cli.arguments import Parser
from tp_jax.errors import InputError

ROOT = Path(__file__).parent.parent.parent
LEDGER = ROOT / "trials" / "shared.jsonl"
PAGE = ROOT / "docs" / "scale.md"


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    args = _parser().parse_args(argv)
    return carried_out("shared_trial", args.run, args, resumes=args.command == "look")


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/shared_trial",
        description="Does a fleet name an effect that its rigs share and that no rig shows alone?",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    looks = commands.add_parser("look", help="save the screens that are not there yet; resumes")
    looks.set_defaults(run=_look)
    counts = commands.add_parser("table", help="count, from the saved screens alone")
    counts.add_argument(
        "--page",
        metavar="F",
        nargs="?",
        const=str(PAGE),
        help="gets the counts in their place (default docs/scale.md)",
    )
    counts.set_defaults(run=_table)
    for each in (looks, counts):
        add_ledger(each, LEDGER)
        each.add_argument("--screens", metavar="DIR", required=True, help="outside the repository")
        each.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _look(args: argparse.Namespace) -> int:
    from scripts._shared_trial.rigs import FLEETS, RIGS, file_of, look

    folder = Path(args.screens).resolve()
    if folder.is_relative_to(ROOT.resolve()):
        raise InputError(f"Screens take space: give --screens a folder outside {ROOT}.")
    done = {
        (each["fleet"], each["rig"])
        for each in entries(Path(args.ledger))
        if each["version"] == args.version
    }
    tasks = [
        (fleet, rig, args.version)
        for fleet in range(1, len(FLEETS) + 1)
        for rig in range(1, RIGS + 1)
        if (fleet, rig) not in done or not file_of(folder, fleet, rig).is_file()
    ]
    _, status = extended("shared_trial", args, functools.partial(look, folder=folder), tasks)
    return status


def _table(args: argparse.Namespace) -> int:
    from scripts._markdown import put_into
    from scripts._shared_trial.told import counted

    told = counted(Path(args.screens), Path(args.ledger), args.version)
    print(told)
    if args.page is not None:
        put_into(Path(args.page), "shared_trial", told)
    return 0


if __name__ == "__main__":
    sys.exit(main())
