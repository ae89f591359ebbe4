"""Clocks that do not run on: counters that start anew, summer time, resets, rows out of order.

What a fall of the times means is told by its size: a counter falls by what it can count to, a
local time by an hour, and a board that was reset to wherever it began.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tp_jax.recordings.gaps import LONGEST_STEP
from tp_jax.recordings.short import short_fields

HOUR = 3600.0
"""s by which summer time begins and ends."""

_BITS = (16, 24, 31, 32)

PERIODS = (
    *(2.0**bits * unit for bits in _BITS for unit in (1.0, 1e-3, 1e-6)),
    86400.0,
    86400e3,
)
"""Periods after which clocks start anew, in a file's own units.

Counters of so many bits, as they are or as their microseconds are written in milliseconds or
seconds, and the seconds and milliseconds of a day.
"""

GAP_AT_WRAP = 1e-3
"""Part of a period that may be missing where it starts anew; 4 s of 32 bits of microseconds.

A reset falls into it by chance in one of a thousand runs that last as long as the period, and in
none that is shorter.
"""

PAUSE_AT_HOUR = 60.0
"""s that may be missing where a date falls back by an hour; no other cause makes a date fall so."""

Cause = Literal["counter", "hour", "row", "order", "anew"]


@dataclass(frozen=True)
class Fall:
    """The first place where times do not rise, or leap by an hour.

    Attributes:
        cause: "counter": it starts anew after `period`; "hour": summer time begins or ends; "row":
            single rows stand out; "order": all rows are there, in another order; "anew": another
            run begins.
        at: index of the first row that is at fault.
        rows: of the same fault, `at` among them.
        period: in the unit of the times given; NaN but for a counter.
    """

    __repr__ = short_fields

    cause: Cause
    at: int
    rows: np.ndarray
    period: float = float("nan")


def usual_step(t: np.ndarray) -> float:
    """The median of the steps forward; 0 where there are none."""
    steps = np.diff(t)
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if steps.size else 0.0


def unit_of_step(step: float) -> str | None:
    """The unit that times without one seem to be in, by the step between samples.

    None: seconds. No torsion pendulum at hand needs as little as one sample in half a second.
    """
    return "us" if step >= 500.0 else "ms" if step > 0.5 else None


def period_of(cells: np.ndarray) -> float | None:
    """Finds the period of a counter, in its own units; None where the first fall is none."""
    cells = cells[np.isfinite(cells)]
    falls = np.flatnonzero(np.diff(cells) < 0.0)
    if not falls.size:
        return None
    i, usual = int(falls[0]), usual_step(cells)
    low, high = float(cells.min()), float(cells.max())
    for period in PERIODS:
        edge = 1.0 if period >= 2.0**16 else 1e-3 * period  # cells are cut to whole ones, or not
        counts = -edge <= low and high <= period + edge
        signed = -0.5 * period - edge <= low and high <= 0.5 * period + edge
        if (counts or signed) and _fits(cells[i + 1] - cells[i] + period, period, usual):
            return period
    return None


def counted_on(cells: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """A counter that starts anew after `period`, counted on, and the indices where it did.

    A fall that is none of the counter's, as a reset's, stays.
    """
    finite = np.flatnonzero(np.isfinite(cells))
    known = cells[finite]
    steps, usual = np.diff(known), usual_step(known)
    anew = (steps < 0.0) & _fits(steps + period, period, usual)
    out = cells.copy()
    out[finite] = known + period * np.concatenate([[0.0], np.cumsum(anew)])
    return out, finite[1:][anew]


def without_hours(t: np.ndarray, dated: bool) -> tuple[np.ndarray, np.ndarray]:
    """Local times [s] without the hours by which they fall back or spring ahead, and where."""
    steps = np.diff(t)
    hours = _hours(t, dated)
    off = np.where(hours, -HOUR * np.sign(steps), 0.0)
    return t + np.concatenate([[0.0], np.cumsum(off)]), np.flatnonzero(hours) + 1


def fall_of(t: np.ndarray, dated: bool, period: float | None, zoned: bool = False) -> Fall | None:
    """Finds why times do not rise; None where they do.

    Args:
        t: (n,) finite times [s].
        dated: they were written as dates or clock times.
        period: as of `period_of`, in seconds.
        zoned: the dates tell their offset from UTC, which has no summer time.
    """
    steps = np.diff(t)
    hours = np.flatnonzero(_hours(t, dated) & (not zoned)) + 1
    falls = np.flatnonzero(steps < 0.0) + 1
    if not falls.size:
        return Fall("hour", int(hours[0]), hours) if hours.size else None
    first = int(falls[0])
    if hours.size and hours[0] <= first:
        return Fall("hour", int(hours[0]), hours)
    if period is not None:
        return Fall("counter", first, falls, period)
    ordered = np.diff(np.sort(t))
    usual = float(np.median(np.abs(steps)))
    # two runs that are laid into each other have steps of half the size or none
    if ordered.min() > 0.5 * usual and ordered.max() < LONGEST_STEP * usual:
        return Fall("order", first, falls)
    bad = [_bad_row(t, int(i)) for i in falls]
    rows = np.array([i for i in bad if i is not None])
    if rows.size == falls.size and np.all(np.diff(np.delete(t, rows)) >= 0.0):
        return Fall("row", int(rows[0]), rows)
    return Fall("anew", first, falls)


def _fits(step: np.ndarray | float, period: float, usual: float) -> np.ndarray | np.bool_ | bool:
    """True where the steps left, once a period is added, are those of a run that goes on."""
    return (step > 0.0) & (step <= max(LONGEST_STEP * usual, GAP_AT_WRAP * period))


def _hours(t: np.ndarray, dated: bool) -> np.ndarray:
    """(n - 1,) whether a step is an hour of summer time, and a usual step besides."""
    steps = np.diff(t)
    near = LONGEST_STEP * usual_step(t)
    back, ahead = steps + HOUR, steps - HOUR
    if dated:
        return ((back > 0.0) & (back <= max(near, PAUSE_AT_HOUR)) & (steps < 0.0)) | (
            (ahead >= 0.0) & (ahead <= near)
        )
    # numbers fall by an hour too where each hour has a log of its own that begins at zero
    begins = np.abs(t[1:] - t[0]) <= near
    return (back > 0.0) & (back <= near) & (steps < 0.0) & ~begins


def _bad_row(t: np.ndarray, i: int) -> int | None:
    """Finds the row to drop for times about the fall to row i to rise; None: neither does it."""
    if i + 1 == t.size or t[i + 1] > t[i - 1]:
        return i
    return i - 1 if i < 2 or t[i] > t[i - 2] else None
