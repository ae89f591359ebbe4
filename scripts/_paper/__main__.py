"""scripts/paper: computes both sections, prints the table, writes numbers and figures."""

import os
import sys
import time
from collections.abc import Sequence
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from tp_jax._config import compile_small_loops, enable_compilation_cache
from tp_jax.cli.arguments import Parser, add_seed
from tp_jax.cli.output import made_folder, write_json

SCHEMA = "tp-jax/paper/1"
NUMBERS = "paper.json"


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    return carried_out("paper", _paper, _parser().parse_args(argv), resumes=False)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/paper",
        description="Czerwinski, Olejnik, Awrejcewicz (2015) again: both identifications with the "
        "paper's own search and with gradients, what its objective sees, its figures.",
    )
    parser.add_argument("--out", metavar="DIR", default="out/paper", help="default ./out/paper")
    parser.add_argument("--quick", action="store_true", help="few and short runs, to see it work")
    add_seed(parser)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _paper(args: Any) -> int:
    folder = made_folder(args.out)
    compile_small_loops()
    import tp_jax._float64  # noqa: F401

    enable_compilation_cache()

    from scripts._paper import section_5_1, section_5_2, table, truth
    from scripts._paper.scale import QUICK, Scale
    from tp_jax import __version__

    begin = time.perf_counter()
    scale = (QUICK if args.quick else Scale())._replace(seed=args.seed)
    result: dict[str, Any] = {
        "schema": SCHEMA,
        "version": __version__,
        "quick": args.quick,
        "scale": scale._asdict(),
    }
    _tell("the printed model")
    result["contact"] = truth.contact(scale.ts)
    result["unseen"] = truth.unseen(scale.ts)
    result["seen"] = truth.seen(scale.ts)
    result["structure"] = truth.structure(scale.ts, scale.points)
    result["section_5_1"] = section_5_1.run(scale, _tell)
    result["section_5_2"] = section_5_2.run(scale, _tell)
    result["wall_s"] = round(time.perf_counter() - begin, 1)
    write_json(folder / NUMBERS, result)
    print("\n".join([*_findings(result), "", *table.lines(result), ""]))
    print(f"Wrote {', '.join(str(p) for p in (folder / NUMBERS, *_drawn(result, scale, folder)))}")
    return 0


def _findings(result: dict[str, Any]) -> list[str]:
    creep, _, fine, _ = result["contact"]["by_eps"]
    unseen = result["unseen"]
    rank = result["structure"]["eleven"]
    return [
        f"No slip in Section 5.1: |φ2| stays below {creep['largest_phi2']:.2g} rad, and below "
        f"{fine['largest_phi2']:.2g} with a hundred times finer smoothing; the torque reaches "
        f"{creep['largest_torque']:.3g} of the {result['contact']['breakaway']:g} N m it takes.",
        "Largest differences of motion: Newton's third law with the column halved "
        f"{unseen['newton_with_the_column_halved']:.2g} rad; all torques and inertias times 7 "
        f"{unseen['all_torques_times_7']:.2g} rad; Ts2 times 100 {unseen['Ts2_times_100']:.2g} "
        "rad.",
        f"Rank {rank['rank']} of {rank['of']}; null: "
        + "; ".join(d["text"] for d in rank["null_directions"])
        + ".",
    ]


def _drawn(result: dict[str, Any], scale, folder) -> list:
    try:
        from scripts._paper.figures import draw

        return draw(result, scale, folder)
    except ImportError as fault:
        if (fault.name or "").split(".")[0] != "matplotlib":
            raise
        print("paper: figures are skipped: matplotlib is not installed.", file=sys.stderr)
        return []


def _tell(line: str) -> None:
    """Says what is going on, for those who wait at a terminal."""
    if sys.stderr.isatty():
        print(f"paper: {line}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
