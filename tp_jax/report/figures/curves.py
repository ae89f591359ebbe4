"""Curves over time as arrays, and what is common to figures over time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tp_jax.results.diagnosis import CHANNELS, HeldOutRun, Numbers, Series

MOST_POINTS = 600

#: Mean square of the second difference over that of the swing, (2π/n)⁴ for n points a period: up
#: to this, a line through the points is the motion (some nine points a period).
_DENSE = 0.25


class Curve(NamedTuple):
    """One channel of one recording over time; what is not known is None."""

    channel: str
    t: np.ndarray
    measured: np.ndarray | None
    before: np.ndarray | None
    after: np.ndarray | None

    def part(self, which: slice) -> "Curve":
        """Some of its points."""
        columns = (self.measured, self.before, self.after)
        return Curve(
            self.channel, self.t[which], *(None if y is None else y[which] for y in columns)
        )


def curves_of(run: HeldOutRun) -> list[Curve]:
    """The channels of an entry of `curves` or `residuals` that have something to draw."""
    t = _array(run.t)
    if t is None:
        return []
    step = -(-len(t) // MOST_POINTS)
    found = []
    for channel in CHANNELS:
        given = getattr(run, channel) or Series()
        columns = [_array(y) for y in (given.measured, given.before, given.after)]
        columns = [y[::step] if y is not None and y.size == t.size else None for y in columns]
        if any(y is not None for y in columns):
            found.append(Curve(channel, t[::step], *columns))
    return found


def drawable(runs: Sequence[HeldOutRun]) -> list[HeldOutRun]:
    """Entries of `curves` or `residuals` that have something to draw."""
    return [run for run in runs if curves_of(run)]


def rms(values: np.ndarray | None) -> float | None:
    """Root of the mean square of what is finite."""
    if values is None:
        return None
    squares = values[np.isfinite(values)] ** 2
    return float(np.sqrt(squares.mean())) if squares.size else None


def largest(*columns: np.ndarray | None) -> float:
    """The largest size among what is finite; 0 where there is nothing."""
    sizes = [np.abs(y[np.isfinite(y)]) for y in columns if y is not None]
    return max((float(y.max()) for y in sizes if y.size), default=0.0)


def error(curve: Curve, of: str) -> np.ndarray | None:
    """Model, `before` or `after`, minus measured."""
    y = getattr(curve, of)
    return None if y is None or curve.measured is None else y - curve.measured


def dense(curve: Curve) -> bool:
    """True where the points lie close enough to be joined by a line.

    The curves of a long recording are thinned, down to a few points a period: a line through them
    would be a motion that never was.
    """
    y = next((y for y in (curve.measured, curve.after, curve.before) if y is not None), None)
    if y is None:
        return False
    y = y[np.isfinite(y)]
    if y.size < 3:
        return False
    swing = np.square(y - y.mean()).mean()
    return bool(np.square(np.diff(y, 2)).mean() <= _DENSE * swing)


def _array(given: Numbers | None) -> np.ndarray | None:
    """None becomes NaN: a break in the curve."""
    array = np.asarray(given or (), dtype=float)
    return array if array.size > 1 and np.isfinite(array).any() else None
