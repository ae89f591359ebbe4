"""The command line, `tp-jax`: one file per command, each with `add_parser` and `run`.

Only the standard library is imported until a command runs, so that `--help` answers at once.

Exit codes: 0 done; 2 bad input, with one sentence on standard error; 1 a fault of ours; 130
interrupted.
"""

import os
import sys
from collections.abc import Sequence

from tp_jax._config import collect_less
from tp_jax.cli.arguments import Parser
from tp_jax.cli.faults import explain
from tp_jax.cli.warned import only_notices


def build_parser() -> Parser:
    from tp_jax._version import __version__
    from tp_jax.cli import (
        calibrate,
        check,
        compare,
        diagnose,
        effects,
        explore,
        identify,
        init,
        moved,
        predict,
        record,
        rig,
        sensitivity,
        serve,
        simulate,
    )

    parser = Parser(
        prog="tp-jax",
        description=(
            "Models a double torsion pendulum with friction and diagnoses its sim-to-real gap: "
            "where it lies, which effect causes it, how far it shrinks."
        ),
        epilog="`tp-jax COMMAND --help` describes a command.",
    )
    parser.add_argument("--version", action="version", version=f"tp-jax {__version__}")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    parser.add_argument("--quiet", action="store_true", help="no summary, no progress")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in (
        simulate,
        calibrate,
        record,
        explore,
        rig,
        init,
        check,
        identify,
        sensitivity,
        diagnose,
        compare,
        predict,
        effects,
        serve,
        moved,
    ):
        command.add_parser(subparsers)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command; returns its exit code."""
    os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config
    collect_less()
    try:
        args = build_parser().parse_args(argv)
    except SystemExit as done:  # --help, --version, or a fault that argparse has reported already
        return int(done.code or 0)
    try:
        with only_notices(debug=args.debug):
            status = args.run(args)
            sys.stdout.flush()
    except KeyboardInterrupt as stop:
        # a command that keeps what it has done says how to go on
        print(f"tp-jax: {str(stop) or 'interrupted.'}", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader has gone, as in `tp-jax simulate | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except Exception as fault:
        return explain(fault, debug=args.debug, campaign=getattr(args, "campaign", None))
    return status or 0
