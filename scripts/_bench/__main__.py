"""scripts/bench: runs the measurements, prints the table, writes the numbers and figures."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from tp_jax._config import cache_folder

# before Numba is imported: what it compiles belongs beside what JAX compiles
os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder().parent / "numba"))

import argparse

from scripts._carried_out import carried_out
from tp_jax.cli.arguments import Parser, positive
from tp_jax.cli.output import made_folder, write_json

SCHEMA = "tp-jax/bench/1"
NUMBERS = "bench.json"
MEASURES = (
    "precision",
    "single",
    "sweep",
    "sensitivities",
    "stuck",
    "robustness",
    "control",
    "scaling",
    "shell",
    "diagnosis",
    "growth",
    "identification",
    "simplices",
)


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    return carried_out("bench", _bench, _parser().parse_args(argv), resumes=False)


def _parser() -> Parser:
    from .peers import MODULES

    parser = Parser(
        prog="scripts/bench",
        description="Runs the engine and other solvers side by side, at equal error.",
    )
    parser.add_argument(
        "--only",
        metavar="NAMES",
        type=_listed(MEASURES),
        default=MEASURES,
        help=f"some of {','.join(MEASURES)}",
    )
    parser.add_argument(
        "--peers",
        metavar="NAMES",
        type=_listed(tuple(MODULES)),
        default=tuple(MODULES),
        help=f"some of {','.join(MODULES)}; ours always runs",
    )
    parser.add_argument(
        "--out", metavar="DIR", default="bench-results", help="default ./bench-results"
    )
    parser.add_argument("--quick", action="store_true", help="few and short runs, to see it work")
    parser.add_argument(
        "--draws-duration",
        metavar="S",
        type=positive,
        default=10.0,
        help="seconds of a run of the robustness (default 10)",
    )
    parser.add_argument(
        "--against",
        metavar="REF",
        help="with --only diagnosis: CPU seconds by stage beside those of this commit, on four "
        "campaigns",
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _listed(known: Sequence[str]):
    def names(text: str) -> tuple[str, ...]:
        given = text.split(",")
        for name in given:
            if name not in known:
                raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(known)}")
        return tuple(name for name in known if name in given)

    return names


def _bench(args: argparse.Namespace) -> int:
    folder = made_folder(args.out)
    import tp_jax._float64  # noqa: F401  # no other setting: a plain process, as a user has it

    from . import machine, peers, problem, table
    from .bench import TARGET, Bench
    from .measures import MEASURES as measures

    where = machine.description()
    wanted = tuple(name for name in peers.MODULES if name == "ours" or name in args.peers)
    found, notes = peers.load(wanted)
    scale = problem.QUICK if args.quick else problem.Scale()
    bench = Bench(scale, found, _tell, args.draws_duration, args.against)

    numbers, rows = {}, []
    for name in args.only:
        numbers[name], more = measures[name](bench)
        rows += more
        # after each measurement: a later one that fails costs no earlier one
        write_json(
            folder / NUMBERS,
            {
                "schema": SCHEMA,
                "machine": where,
                "quick": args.quick,
                "target": TARGET,
                "scale": scale._asdict(),
                "peers": [peer.name for peer in found],
                "notes": notes,
                "rows": [row._asdict() for row in rows],
                "measures": numbers,
            },
        )
    notes += _drawn(numbers, [peer.name for peer in found], folder)
    table.show(rows, where, notes)
    return 0


def _drawn(numbers: dict, names: list[str], folder: Path) -> list[str]:
    try:
        from .figures import draw

        written = draw(numbers, names, folder)
    except ImportError as fault:
        if (fault.name or "").split(".")[0] != "matplotlib":
            raise
        return [f"Wrote {folder / NUMBERS}; figures are skipped: matplotlib is not installed."]
    return [f"Wrote {', '.join(str(path) for path in (folder / NUMBERS, *written))}"]


def _tell(line: str) -> None:
    """Says what is going on, for those who wait at a terminal."""
    if sys.stderr.isatty():
        print(f"bench: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
