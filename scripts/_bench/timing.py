"""Timings: paired and interleaved, so that what else the machine does hits all alike."""

import gc
import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

SHORTEST = 0.02
"""Seconds that one reading lasts at least; a shorter call is repeated."""

ENOUGH = 25
"""Rounds of readings, if there is time for so many."""


class Spread(NamedTuple):
    """Median and quartiles of repeated readings."""

    median: float
    low: float
    high: float


def spread(values: Sequence[float]) -> Spread:
    """Median and interquartile range."""
    low, median, high = np.percentile(values, (25, 50, 75))
    return Spread(float(median), float(low), float(high))


def seconds(call: Callable[[], Any], repeats: int = 1) -> float:
    """Seconds of one call, as the mean over some in a row."""
    start = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - start) / repeats


def interleaved(
    calls: Mapping[str, Callable[[], Any]],
    rounds: int,
    *,
    warm: bool = False,
    budget: float = 0.0,
) -> dict[str, list[float]]:
    """Seconds of each call in each round: A B C, A B C, ...

    More rounds than asked for, up to `ENOUGH`, as long as the budget [s] lasts.
    Each is called twice beforehand: for what it compiles, and for how often it has to be repeated.
    Not so if they are `warm`: called before, and long.
    """
    repeats = dict.fromkeys(calls, 1)
    for name, call in calls.items():
        if not warm:
            call()
            repeats[name] = max(1, math.ceil(SHORTEST / max(seconds(call), 1e-7)))
    readings: dict[str, list[float]] = {name: [] for name in calls}
    collected = gc.isenabled()
    gc.disable()
    try:
        start = time.perf_counter()
        done = 0
        while done < rounds or (done < ENOUGH and time.perf_counter() - start < budget):
            for name, call in calls.items():
                readings[name].append(seconds(call, repeats[name]))
            done += 1
    finally:
        if collected:
            gc.enable()
    return readings


def ratio(readings: Mapping[str, Sequence[float]], name: str, to: str) -> Spread:
    """Computes how many times as long `name` takes as `to`: from the pairs of each round."""
    return spread([a / b for a, b in zip(readings[name], readings[to], strict=True)])


def capped(call: Callable[[float], Any], duration: float, cap: float) -> tuple[float, Any]:
    """Seconds and result of `call(duration)`, or infinity and None if they would exceed the cap.

    No call can be stopped from outside, so shorter durations go first, ten times as long each
    time, and what they took tells whether the next may start. The first may take what it likes
    (something is compiled).
    """
    short = duration * 1e-3
    call(short)
    for part in (1e-3, 1e-2, 1e-1, 1.0):
        start = time.perf_counter()
        result = call(duration * part)
        took = time.perf_counter() - start
        if part < 1.0 and 10.0 * took > cap * 1.5:
            return math.inf, None
    return (took, result) if took <= cap else (math.inf, None)
