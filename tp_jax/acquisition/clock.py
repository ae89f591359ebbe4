"""The rig's clock against the host's: offset and skew, from when samples arrived.

A sample arrives late, never early: by the line, the USB frame, the scheduler. So the relation of
the two clocks is the line *below* all points (rig's time, host's time − rig's time) with the least
sum of distances: of the edges of their lower convex hull the one that spans the mean of the rig's
times. That is the maximum likelihood estimate for exponentially distributed delays, and a delay
that saws between two polls of a bus, as the beat of two clocks makes it, does not tilt it as it
tilts a least-squares line.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

LEAST_POINTS, LEAST_SPAN = 20, 1.0  # arrivals and seconds below which nothing is said
MOST_BLOCKS, _FOLDS = 240, 10


@dataclass(frozen=True)
class ClockFit:
    """host time = offset + rig time / (1 + skew), with standard errors."""

    offset: float  # host's clock at t = 0 of the rig's [s], the shortest delay included
    skew: float  # relative rate of the rig's clock, above zero it is fast; 1e-6 is 1 ppm
    offset_error: float
    skew_error: float
    bend: float  # largest difference of the skew in either half of the recording from that of all
    delay: float  # median delay of the points beyond the shortest [s]
    points: int  # arrivals that were used


def fit_clock(rig: ArrayLike, host: ArrayLike, poll: float = 0.0) -> ClockFit | None:
    """Estimates offset and skew; None where there are too few points, or all within `LEAST_SPAN`.

    Args:
        rig: (n,) times of samples on the rig's clock [s].
        host: (n,) when they had arrived, on the host's [s].
        poll: how often the bus between them is asked [s], 1e-3 for USB. A delay that creeps
            through less than one such period in the whole recording looks like a skew, and no
            estimate can tell: it is counted among the errors.
    """
    d, h = np.asarray(rig, dtype=float), np.asarray(host, dtype=float)
    if d.size < LEAST_POINTS or np.ptp(d) < LEAST_SPAN:
        return None
    order = np.argsort(d, kind="stable")
    d, delay = d[order], (h - d)[order]
    part, span = (d - d[0]) / (d[-1] - d[0]), d[-1] - d[0]
    # the least delayed point of each of many spans of equal length
    blocks = min(MOST_BLOCKS, d.size)
    block = np.minimum(part * blocks, blocks - 1).astype(int)
    by_delay = np.lexsort((delay, block))
    low = by_delay[np.flatnonzero(np.diff(block[by_delay], prepend=-1))]
    x, y = d[low], delay[low]
    slope, intercept = _line_below(x, y)

    # how the line moves when a tenth of the time is left out, and how it could be tilted by the
    # delays that are always there
    fold = np.minimum(part[low] * _FOLDS, _FOLDS - 1).astype(int)
    kept = [fold != k for k in range(_FOLDS)]
    others = [_line_below(x[k], y[k]) for k in kept if np.unique(x[k]).size > 1]
    spread = np.sqrt((len(others) - 1) * np.var(others, axis=0)) if others else np.full(2, np.inf)
    halves = [
        _line_below(x[k], y[k])[0] for k in (part[low] < 0.5, part[low] >= 0.5) if k.sum() > 1
    ]
    hidden = np.hypot(np.median(y - intercept - slope * x), poll / np.sqrt(12.0))
    return ClockFit(
        offset=intercept,
        skew=1.0 / (1.0 + slope) - 1.0,  # host = d + intercept + slope d
        offset_error=float(np.hypot(spread[1], hidden)),
        skew_error=float(np.hypot(spread[0], hidden / span)),
        bend=max((abs(each - slope) for each in halves), default=0.0),
        delay=float(np.median(delay - intercept - slope * d)),
        points=d.size,
    )


def _line_below(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope and intercept of the edge of the lower convex hull that spans the mean of x."""
    hull: list[int] = []
    for i in range(x.size):
        while len(hull) > 1:
            a, b = hull[-2], hull[-1]
            if (x[b] - x[a]) * (y[i] - y[a]) > (x[i] - x[a]) * (y[b] - y[a]):
                break
            hull.pop()
        hull.append(i)
    hx, hy = x[hull], y[hull]
    k = int(np.clip(np.searchsorted(hx, x.mean()), 1, hx.size - 1))
    slope = (hy[k] - hy[k - 1]) / (hx[k] - hx[k - 1])
    return float(slope), float(hy[k] - slope * hx[k])
