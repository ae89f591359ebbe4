"""Robustness, ours only: runs anywhere in the bounds, none of which may be lost."""

import time

import numpy as np

from ..bench import Bench, reach
from ..peers import ours
from ..problem import anywhere
from ..rows import Row, duration, held, smoothing

PART = 1024
"""Draws of one sweep: the progress is reported after each."""


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"results": [{eps, draws, duration, lost, rows_lost, steps, seconds}]}."""
    table = anywhere(b.scale.draws)
    ts = reach(b.scale, b.draws_duration)
    results, rows = [], []
    for eps in b.scale.eps:
        b.tell(f"robustness, {smoothing(eps)}: {len(table)} draws of {ts[-1]:g} s")
        tol, _ = b.tolerance(b.ours, eps)
        start = time.perf_counter()
        complete, steps = _in_parts(b, table, eps, ts, tol)
        took = time.perf_counter() - start
        lost = np.flatnonzero(~complete)
        median, slowest = float(np.median(steps)), int(np.max(steps))
        results.append(
            {
                "eps": eps,
                "draws": len(table),
                "duration": ts[-1],
                "tolerance": tol,
                "lost": lost.size,
                "rows_lost": table[lost[:20]],
                "steps": {
                    "median": median,
                    "p99": float(np.percentile(steps, 99)),
                    "slowest": slowest,
                    "slowest_row": table[int(np.argmax(steps))],
                },
                "seconds": took,
            }
        )
        value = f"{lost.size} of {len(table)} lost, {duration(took)} in all"
        case = smoothing(eps)
        rows.append(held("lost", "robustness", case, b.ours.name, float(lost.size), value))
        factor = slowest / median
        value = f"slowest {slowest} steps, median {median:.0f}: {factor:.3g} ×"
        rows.append(held("slowest", "robustness", case, b.ours.name, factor, value))
    return {"results": results}, rows


def _in_parts(b: Bench, table, eps, ts, tol) -> tuple[np.ndarray, np.ndarray]:
    """`ours.steps` of the whole table."""
    complete, steps = np.zeros(0, bool), np.zeros(0, int)
    for start in range(0, len(table), PART):
        begun = time.perf_counter()
        more = ours.steps(table[start : start + PART], eps, ts, tol)
        complete, steps = np.append(complete, more[0]), np.append(steps, more[1])
        b.tell(
            f"{steps.size} draws: {np.sum(~complete)} lost, median {np.median(steps):.0f} steps, "
            f"slowest {np.max(steps)} (draw {np.argmax(steps)}), "
            f"the last {len(more[1])} in {duration(time.perf_counter() - begun)}"
        )
    return complete, steps
