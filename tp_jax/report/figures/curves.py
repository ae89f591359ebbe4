"""Curves over time as arrays, and what is common to figures over time."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tp_jax.report import reading

MOST_POINTS = 600


class Curve(NamedTuple):
    """One channel of one recording over time; what is not known is None."""

    channel: str
    t: np.ndarray
    measured: np.ndarray | None
    before: np.ndarray | None
    after: np.ndarray | None


def curves_of(entry: Mapping[str, Any]) -> list[Curve]:
    """The channels of an entry of `curves` or `residuals` that have something to draw."""
    t = _array(entry.get("t"))
    if t is None:
        return []
    step = -(-len(t) // MOST_POINTS)
    found = []
    for channel in reading.CHANNELS:
        given = reading.table(entry, channel)
        columns = [_array(given.get(key)) for key in ("measured", "before", "after")]
        columns = [y[::step] if y is not None and y.size == t.size else None for y in columns]
        if any(y is not None for y in columns):
            found.append(Curve(channel, t[::step], *columns))
    return found


def drawable(diagnosis: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    """Entries of `curves` or `residuals` that have something to draw."""
    return [entry for entry in reading.rows(diagnosis, key) if curves_of(entry)]


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


def _array(given: Any) -> np.ndarray | None:
    if not isinstance(given, list | tuple | np.ndarray) or len(given) < 2:
        return None
    try:
        array = np.asarray(given, dtype=float)  # null becomes NaN: a break in the curve
    except (TypeError, ValueError):
        return None
    return array if array.ndim == 1 and np.isfinite(array).any() else None
