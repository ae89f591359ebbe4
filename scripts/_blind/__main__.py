"""scripts/blind: a sealed trial of the diagnosis, in the command that is asked for."""

import argparse
import os
import sys
from collections.abc import Sequence

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._blind import make_and_score, pool, run
from scripts._carried_out import carried_out
from tp_jax.cli.arguments import Parser
from tp_jax.cli.warned import only_notices

RUN = "run"
"""The command that a line without one means."""

POOL = "pool"


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    parser, commands = _parser()
    if not words or words[0] not in {*commands, "-h", "--help"}:
        words = [RUN, *words]
    try:
        args = parser.parse_args(words)
    except SystemExit as done:  # --help, or a fault that argparse has reported already
        return int(done.code or 0)
    return carried_out("blind", _carry_out, args, resumes=args.command in (RUN, POOL))


def _carry_out(args: argparse.Namespace) -> int:
    with only_notices(debug=args.debug):
        return args.run(args)


def _parser() -> tuple[Parser, set[str]]:
    """The parser, and the names of its commands."""
    parser = Parser(
        prog="scripts/blind",
        description="A blind trial of the diagnosis on campaigns of the virtual rig, whose hidden "
        "effects are under seal until every diagnosis is written. Without a command: run.",
        epilog="`scripts/blind COMMAND --help` describes a command.",
    )
    parser.set_defaults(quiet=False, debug=False)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    make_and_score.add_parsers(commands)
    run.add_parser(commands)
    pool.add_parser(commands)
    return parser, set(commands.choices)


if __name__ == "__main__":
    sys.exit(main())
