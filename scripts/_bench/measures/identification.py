"""Many starts: `tp_jax.identify` beside the SciPy script a good engineer would write.

The same recordings of a virtual rig and the same bounds, a decade each way; both on two cores or
more. A start has reached the best where its chi-square is within one of the best of its own program
(the objectives differ: windows here, free runs there, with friction as smooth as a search's; and
ours finds the drive's phase and the zero of phi1 too, which are zero).
"""

import math
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..bench import Bench
from ..problem import SEARCHED
from ..rows import Row, duration, plain, times

DECADE = 10.0
REACHED = 1.0  # of chi-square
RIGHT = 0.02  # of the truth
WELL_KNOWN = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1")  # Tst and T0 nearly make up for each other


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"results": [{peer, starts, reached, right, seconds}]}; ours first."""
    b.tell("identification")
    from .. import campaign as rig

    data, starts = rig.made(b.scale.runs, b.scale.recording), b.scale.starts
    truth = rig.truth()
    bound = {n: (truth[n] / DECADE, truth[n] * DECADE) for n in SEARCHED}
    results = [_ours(data, bound, starts, truth)]
    tol = rig.cvodes_tolerance(b)
    if tol is not None:
        results.append(_scipy(data, bound, starts, truth, tol))
    rows = [_row(one, results[0]) for one in results]
    return {"results": results, "runs": b.scale.runs, "starts": starts}, rows


def _ours(data: Any, bound: Mapping, starts: int, truth: Mapping) -> dict[str, Any]:
    import tp_jax as tp

    # the data's own start comes first, and is none of those that are drawn
    call = lambda: tp.identify(data, starts=starts + 1, bound=bound)  # noqa: E731
    call()
    begin = time.perf_counter()
    found = call()
    seconds = time.perf_counter() - begin
    result = found.to_dict()
    ends = [s["objective"] for s in result["starts"]]
    values = {n: result["parameters"][n]["value"] for n in truth if n in result["parameters"]}
    return _told("tp-jax", ends, ends[1:], values, truth, seconds)


def _scipy(data: Any, bound: Mapping, starts: int, truth: Mapping, tol: float) -> dict[str, Any]:
    from tp_jax.estimation.prepared_campaign import prepare_campaign

    from .. import campaign as rig
    from .. import pool, scipy_script

    given = rig.as_plain(prepare_campaign(data, effects=()), tol)
    lower, upper = np.array([bound[n] for n in SEARCHED]).T
    x0 = scipy_script.starts(starts, lower, upper, seed=0)
    tasks = [(scipy_script.__name__, "fit", x, given, lower, upper) for x in x0]
    # the processes are there, with what they import, before the clock runs
    first = (scipy_script.__name__, "angles", given, np.exp(x0[0]))
    list(pool.workers().map(pool.one, *([x] * pool.cores() for x in first)))
    begin = time.perf_counter()
    ends = [f.result() for f in [pool.workers().submit(pool.one, *task) for task in tasks]]
    seconds = time.perf_counter() - begin
    objectives = [float(end[1]) for end in ends]
    best = np.exp(ends[int(np.argmin(objectives))][0])
    values = dict(zip(SEARCHED, best.tolist(), strict=True))
    out = _told("SciPy and CVODES", objectives, objectives, values, truth, seconds)
    return {**out, "evaluations": [end[2] for end in ends]}


def _told(
    peer: str,
    ends: Sequence[float | None],
    drawn: Sequence[float | None],
    values: Mapping[str, float],
    truth: Mapping[str, float],
    seconds: float,
) -> dict[str, Any]:
    best = min(x for x in ends if x is not None)
    errors = {n: abs(values[n] / truth[n] - 1.0) for n in WELL_KNOWN}
    return {
        "peer": peer,
        "starts": len(drawn),
        "seconds": seconds,
        "reached": sum(x is not None and x <= best + REACHED for x in drawn),
        "above": [None if x is None or not math.isfinite(x) else x - best for x in drawn],
        "errors": errors,
        "right": sum(e <= RIGHT for e in errors.values()),
    }


def _row(one: Mapping[str, Any], ours: Mapping[str, Any]) -> Row:
    value = (
        f"{one['reached']} of {one['starts']} starts reach the best, {duration(one['seconds'])}; "
        f"{one['right']} of {len(one['errors'])} parameters within {RIGHT:.0%} there"
    )
    if one is not ours:
        value += f"; ours takes {times(ours['seconds'] / one['seconds'])} that"
    return plain("identification", f"{one['starts']} starts", one["peer"], value)
