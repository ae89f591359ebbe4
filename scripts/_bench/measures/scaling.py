"""Scaling, ours only: cost and memory per lane from few lanes to many.

Each number of lanes in a process of its own (see `alone`).
"""

from ..alone import FEW, sweep_alone
from ..bench import Bench
from ..rows import Row, duration, held, plain, smoothing, times

LONGEST = 120.0  # s, of one sweep


def measure(b: Bench) -> tuple[dict, list[Row]]:
    """{"results": [{eps, lanes, seconds_per_lane, over_few, bytes_per_lane}], "skipped"}."""
    eps = b.scale.eps[-1]
    tol, _ = b.tolerance(b.ours, eps)
    results, rows, skipped = [], [], []
    cost = 0.0
    for lanes in b.scale.scaling:
        if cost * lanes > LONGEST:
            skipped.append(lanes)
            words = f"{lanes} lanes skipped: about {duration(cost * lanes)} of one sweep"
            rows.append(plain("scaling", smoothing(eps), b.ours.name, words))
            continue
        b.tell(f"scaling, {lanes} lanes")
        one = sweep_alone(lanes, eps, tol, b.scale.duration)
        results.append({"eps": eps, "tolerance": tol, **one})
        cost = one["seconds_per_lane"]
        over = one["over_few"]
        value = f"{lanes} lanes: {duration(cost)} a lane, {times(over['median'])} that of {FEW}"
        value += f" ({over['low']:.2g} to {over['high']:.2g})"
        rows.append(plain("scaling", smoothing(eps), b.ours.name, value))
    last = results[-1]
    factor = last["over_few"]["median"]
    value = f"{last['lanes']} lanes: a lane {times(factor)} that of {FEW}"
    rows.append(held("scaling", "scaling", smoothing(eps), b.ours.name, factor, value))
    factor = last["bytes_per_lane"] / last["bytes_of_angles"]
    value = f"{last['lanes']} lanes: {last['bytes_per_lane'] / 1e3:.3g} kB a lane, "
    value += f"{factor:.2g} × the memory of its angles"
    rows.append(plain("scaling", smoothing(eps), b.ours.name, value))
    return {"results": results, "skipped": skipped}, rows
