"""The stuck contact: what a simulated second takes, against that of the sliding preset.

And the sliding preset itself, at the package's own slope against the one printed.
"""

import math
from collections.abc import Callable

import numpy as np

from ..bench import Bench, largest
from ..peer import Peer
from ..problem import PAPER, bench
from ..rows import Row, duration, held, plain, smoothing, times
from ..timing import interleaved, ratio, spread

SLIDING = "sliding"
CASES = {
    SLIDING: bench(),
    "B2 a hundredth": bench(B2=0.01),
    "Section 5.1": np.array(PAPER),
}


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"cap", "results": [{peer, eps, case, seconds_per_second, relative, error}]}; null: > cap."""
    b.tell(f"stuck: {b.ours.name}")
    results, slopes = _ours(b)
    for eps in b.scale.eps:
        for peer in b.peers[1:]:
            b.tell(f"stuck, {smoothing(eps)}: {peer.name}")
            results += _other(b, peer, eps)
    rows = [_row(b, one) for one in results if one["case"] != SLIDING]
    # by case rather than by peer
    rows.sort(key=lambda row: row.case)
    return {"cap": b.scale.cap, "results": results}, rows + slopes


def _ours(b: Bench) -> tuple[list[dict], list[Row]]:
    """Results of all slopes, timed in turns since they are held against each other."""
    calls: dict[str, Callable] = {}
    results = []
    for eps in b.scale.eps:
        tol, _ = b.tolerance(b.ours, eps)
        for case, row in CASES.items():
            calls[_key(case, eps)] = lambda row=row, eps=eps, tol=tol: b.ours.run(
                row, eps, b.scale.ts, tol
            )
            error = largest(b.ours.run(row, eps, b.scale.ts, tol), b.truth(row, eps, b.scale.ts))
            results.append(_result(b.ours, eps, case, error, tol))
    readings = interleaved(calls, b.scale.pairs, budget=b.scale.budget)
    for one in results:
        key = _key(one["case"], one["eps"])
        one["seconds_per_second"] = spread(readings[key]).median / b.scale.duration
        one["relative"] = ratio(readings, key, _key(SLIDING, one["eps"])).median
    rows = []
    first = _key(SLIDING, b.scale.eps[0])
    for eps in b.scale.eps[1:]:
        key = _key(SLIDING, eps)
        factor = ratio(readings, key, first).median
        took = duration(spread(readings[key]).median / b.scale.duration)
        value = f"{took} a second, {times(factor)} that at {smoothing(b.scale.eps[0])}"
        rows.append(
            held("slope", "stuck", f"{SLIDING}, {smoothing(eps)}", b.ours.name, factor, value)
        )
    return results, rows


def _other(b: Bench, peer: Peer, eps: float) -> list[dict]:
    """Results of one peer, each timed alone since it may exceed the cap."""
    tol, _ = b.tolerance(peer, eps)
    results, sliding = [], math.nan
    for case, row in CASES.items():
        took, angles = b.timed(peer, row, eps, tol)
        sliding = took if case == SLIDING else sliding
        error = math.inf if angles is None else largest(angles, b.truth(row, eps, b.scale.ts))
        results.append(
            {
                **_result(peer, eps, case, error, tol),
                "seconds_per_second": took / b.scale.duration,
                "relative": took / sliding,
            }
        )
    return results


def _key(case: str, eps: float) -> str:
    return f"{case}, {smoothing(eps)}"


def _result(peer: Peer, eps: float, case: str, error: float, tol: float) -> dict:
    return {"peer": peer.name, "eps": eps, "case": case, "error": error, "tolerance": tol}


def _row(b: Bench, one: dict) -> Row:
    cost, relative = one["seconds_per_second"], one["relative"]
    if not math.isfinite(cost):
        value = f"> cap of {b.scale.cap:g} s for {b.scale.duration:g} s"
    else:
        value = f"{duration(cost)} a second, {relative:.2g} × sliding, error {one['error']:.1e}"
    case = _key(one["case"], one["eps"])
    if one["peer"] == b.ours.name:
        return held("stuck", "stuck", case, one["peer"], relative, value)
    return plain("stuck", case, one["peer"], value)
