"""Program of scripts/accelerator: sweeps of many sizes on the device that JAX finds."""

import os
import sys
import time
from collections.abc import Callable
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

import numpy as np

from scripts import _markdown as markdown
from scripts._bench import problem
from tp_jax.cli.arguments import Parser, count

TOLERANCE = 1e-6  # rad, the package's default
FINE = 1e-9  # rad, of the runs that the first are held to
HELD = 64
"""Runs that are taken with finer steps too, and by --save written for another machine's."""

SENSITIVE = 256
"""Runs whose sensitivities by all parameters and starts are taken."""

HEADS = ("eps [s]", "what", "runs", "seconds", "ms a run", "incomplete", "error [rad]")


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of a second call, when all is compiled, and its result."""
    work()
    begin = time.perf_counter()
    found = work()
    return time.perf_counter() - begin, found


def rows(sizes: list[int], duration: float, save: str | None = None) -> list[tuple[str, ...]]:
    """Rows of the table, also printed as they come; see `HEADS`."""
    from scripts._bench.peers import ours

    ts, found, kept = problem.times(duration), [], {}

    def add(eps: float, what: str, many: int, took: float, lost: str, error: str) -> None:
        each = f"{1e3 * took / many:.3f}"
        found.append((f"{eps:g}", what, f"{many:,}", f"{took:.2f}", each, lost, error))
        print(markdown.row(found[-1]), flush=True)

    for eps in problem.EPS:
        for many in sizes:
            table = problem.sweep(many)
            took, swept = timed(lambda t=table, e=eps: ours.motions(t, e, ts, TOLERANCE))
            lost = int((~np.asarray(swept.complete)).sum())
            fine = ours.motions(table[:HELD], eps, ts, FINE)
            error = np.abs(np.asarray(swept.phi2)[:HELD] - np.asarray(fine.phi2)).max()
            add(eps, "sweep", many, took, str(lost), f"{error:.1e}")
            kept[f"phi2 {eps:g}"] = np.asarray(fine.phi2)
        table = problem.sweep(SENSITIVE)
        took, _ = timed(lambda t=table, e=eps: ours.many_sensitivities(t, e, ts, TOLERANCE))
        add(eps, "sensitivities", SENSITIVE, took, "", "")
    if save is not None:
        np.savez(save, **kept)
    return found


def main(argv: list[str] | None = None) -> int:
    """Prints the table and where it was made."""
    parser = Parser(
        prog="scripts/accelerator",
        description="Times sweeps on the device that JAX finds: a GPU, or the CPU.",
    )
    parser.add_argument(
        "--runs",
        metavar="N",
        type=count,
        nargs="+",
        default=[256, 4096, 65536],
        help="sizes of the sweeps (default 256 4096 65536)",
    )
    parser.add_argument(
        "--duration", metavar="S", type=float, default=10.0, help="of a run (default 10)"
    )
    parser.add_argument(
        "--save", metavar="F", help=f"gets {HELD} runs with fine steps, to compare machines"
    )
    args = parser.parse_args(argv)

    import jax

    import tp_jax as tp

    tp.enable_compilation_cache()
    print(markdown.row(HEADS), flush=True)
    print(markdown.row("---" for _ in HEADS), flush=True)
    rows(args.runs, args.duration, args.save)
    print(f"\n{jax.devices()[0].device_kind}; {markdown.circumstances(0)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
