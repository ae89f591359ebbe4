"""scripts/evidence: saves screens of drawn rigs, or compares two ways of judging them."""

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from tp_jax.cli.arguments import Parser, positive, whole
from tp_jax.errors import InputError

ROOT = Path(__file__).parent.parent.parent
MOST = 10_000  # rigs of a kind; a year of saving them


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    args = _parser().parse_args(argv)
    return carried_out("evidence", args.run, args, resumes=args.command == "save")


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/evidence",
        description="Would one log evidence decide better than today's rules whether anything is "
        "there, and which effect? Saves the first screens of drawn rigs and compares.",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    save = commands.add_parser("save", help="save screens, resumably, in one gentle process")
    save.add_argument("--to", metavar="DIR", required=True, help="outside the repository")
    save.add_argument("--clean", metavar="N", type=_rigs, default=60, help="rigs (default 60)")
    save.add_argument("--rough", metavar="N", type=_rigs, default=40, help="rigs (default 40)")
    save.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no rig after so many seconds",
    )
    save.set_defaults(run=_save)
    table = commands.add_parser("table", help="compare, from the saved screens alone")
    table.add_argument("--of", metavar="DIR", required=True, help="where the screens are")
    table.add_argument("--markdown", metavar="F", help="gets the tables, replacing it")
    table.set_defaults(run=_table)
    for each in (save, table):
        each.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _rigs(text: str) -> int:
    return whole(text, least=0, most=MOST)


def _save(args: argparse.Namespace) -> int:
    from scripts._evidence.saving import save_all

    folder = Path(args.to).resolve()
    if folder.is_relative_to(ROOT.resolve()):
        raise InputError(f"Screens take megabytes each: give --to a folder outside {ROOT}.")
    wanted = {rigs: n for rigs, n in (("clean", args.clean), ("rough", args.rough)) if n}
    return save_all(folder, wanted, time.monotonic() + args.limit_s)


def _table(args: argparse.Namespace) -> int:
    from scripts import _markdown as markdown
    from scripts._evidence.comparison import answers, tables
    from scripts._evidence.saving import SEED
    from tp_jax.cli.output import write_text

    found = answers(Path(args.of))
    if not found:
        raise InputError(f"{args.of} holds no saved screens; `./scripts/evidence save` makes them.")
    told = f"{tables(found)}\n\n{markdown.circumstances(SEED)}\n"
    print(told, end="")
    if args.markdown is not None:
        write_text(Path(args.markdown), told)
    return 0


if __name__ == "__main__":
    sys.exit(main())
