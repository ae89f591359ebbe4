"""scripts/attack: attacks every door, and tells what became of it."""

import argparse
import os
import sys
import time
import warnings
from collections.abc import Sequence

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._attack.tally import Tally
from scripts._carried_out import carried_out
from tp_jax.cli.arguments import Parser, add_seed, whole

DOORS = ("readers", "commands", "kills", "places", "searches")


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code: 1 where there are faults."""
    return carried_out("attack", _attack, _parser().parse_args(argv), resumes=False)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/attack",
        description="Broken and hostile input at every door: what was tried, refused, done; faults "
        "of ours. Without arguments ten minutes or so.",
    )
    parser.add_argument(
        "--inputs", metavar="N", type=whole, default=20_000, help="to readers (20000)"
    )
    parser.add_argument(
        "--lines", metavar="N", type=whole, default=1_000, help="command lines (1000)"
    )
    parser.add_argument(
        "--kills",
        metavar="N",
        type=whole,
        default=200,
        help="processes killed while they write (200)",
    )
    parser.add_argument(
        "--searches",
        metavar="N",
        type=whole,
        default=0,
        help="of identify, killed and gone on with, a minute each (0)",
    )
    parser.add_argument("--only", choices=DOORS, help="nothing else")
    parser.add_argument("--door", metavar="NAME", help="of the readers only this one")
    add_seed(parser)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _attack(args: argparse.Namespace) -> int:
    from scripts._attack import commands, kills, places, readers, searches

    # libraries' warnings are not for users either, see tp_jax.cli.warned
    warnings.simplefilter("ignore")
    tally = Tally()
    work = {
        "kills": lambda: kills.attack(tally, args.kills, args.seed),  # before JAX has threads
        "readers": lambda: readers.attack(tally, args.inputs, args.seed, args.door),
        "commands": lambda: commands.attack(tally, args.lines, args.seed),
        "places": lambda: places.attack(tally),
        "searches": lambda: searches.attack(tally, args.searches, args.seed),
    }
    begun = time.monotonic()
    for name, attack in work.items():
        if args.only in (None, name):
            attack()
    print("\n".join(tally.lines()))
    print(f"{time.monotonic() - begun:.0f} s")
    return 1 if tally.faults else 0


if __name__ == "__main__":
    sys.exit(main())
