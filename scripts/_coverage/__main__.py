"""scripts/coverage: studies rigs until enough are there, then tells how often intervals held."""

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from scripts._coverage.settings import QUICK, Settings
from tp_jax.cli.arguments import Parser, add_executor, add_seed, count, executor_of, positive
from tp_jax.cli.output import made_folder, write_json
from tp_jax.errors import InputError

SCHEMA = "tp-jax/coverage/1"
RIGS, NUMBERS, FIGURE, SETTINGS = "rigs.jsonl", "coverage.json", "coverage.png", "settings.json"


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    return carried_out("coverage", _coverage, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/coverage",
        description="How often 95 % intervals hold the truth, over simulated rigs. Resumes.",
    )
    parser.add_argument("--out", metavar="DIR", default="out/coverage", help="./out/coverage")
    parser.add_argument("--rigs", metavar="N", type=count, default=500, help="default 500")
    add_seed(parser)
    add_executor(parser)
    parser.add_argument("--runs", metavar="N", type=count, help="recordings of a campaign (6)")
    parser.add_argument("--duration", metavar="S", type=positive, help="of a recording (10)")
    parser.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no rig after so many seconds",
    )
    parser.add_argument("--quick", action="store_true", help="short campaigns, to see it work")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _coverage(args: argparse.Namespace) -> int:
    from scripts._coverage.pool import read, studied, told
    from scripts._coverage.tally import lines, tally
    from tp_jax.cli.progress import shown

    until = time.monotonic() + args.limit_s
    folder = made_folder(args.out)
    settings = _settings(args)
    _same_study(folder / SETTINGS, settings)
    known = read(folder / RIGS)
    wanted = [i for i in range(args.rigs) if i not in known]
    with shown(quiet=False) as progress:
        failed = studied(folder / RIGS, wanted, settings, executor_of(args), until, progress)
    told(failed)
    results = {i: r for i, r in read(folder / RIGS).items() if i < args.rigs}
    found = tally(results)
    seconds = [sum(r["seconds"].values()) for r in results.values()]
    write_json(
        folder / NUMBERS,
        {
            "schema": SCHEMA,
            "settings": settings._asdict(),
            "rigs": len(results),
            "of": args.rigs,
            "failed": {str(i): fault for i, fault in failed.items()},
            "not_converged": sum(not r["converged"] for r in results.values()),
            "seconds_per_rig": sum(seconds) / max(len(seconds), 1),
            "parameters": found,
        },
    )
    print("\n".join(lines(found)))
    left = args.rigs - len(results)
    if left:
        print(f"{left} of {args.rigs} rigs are left; the same call goes on.")
    if found:
        _drawn(found, folder / FIGURE)
    print(f"Wrote {folder / NUMBERS}")
    return 1 if failed else 0


def _settings(args: argparse.Namespace) -> Settings:
    settings = QUICK if args.quick else Settings()
    chosen = {n: v for n in ("runs", "duration") if (v := getattr(args, n)) is not None}
    return settings._replace(seed=args.seed, **chosen)


def _same_study(path: Path, settings: Settings) -> None:
    """Rigs of different studies must not be counted together."""
    if path.is_file():
        if json.loads(path.read_text(encoding="utf-8")) != settings._asdict():
            raise InputError(
                f"{path.parent} holds a study with other settings; give another --out."
            )
        return
    write_json(path, settings._asdict())


def _drawn(found: dict, path: Path) -> None:
    try:
        from scripts._coverage.figure import draw

        draw(found, path)
    except ImportError as fault:
        if (fault.name or "").split(".")[0] != "matplotlib":
            raise
        print("coverage: no figure: matplotlib is not installed.", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
