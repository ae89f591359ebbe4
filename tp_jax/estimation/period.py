"""The typical period of a campaign's motion, and the window lengths that follow from it."""

from collections.abc import Sequence

import numpy as np

from tp_jax.recordings import Recording, stretches

STILL = 2.0
"""Times its swings that a decay may last, at rest in the end; what is more does not count."""


def typical_period(recordings: Sequence[Recording]) -> float:
    """Typical period of the column [s]: from the crossings of its mean, gaps left out.

    Of a decay that has come to rest, the stillness counts no longer than its swings did: a minute
    of it would make windows in which no fit finds its way. One that hardly swings tells a quarter
    of a period, until it is first near where it ends; that counts where nothing swings.
    """
    periods, quarters = [], []
    for r in recordings:
        y = r.phi1 - r.phi1.mean()
        y = np.where(np.abs(y) < 0.1 * np.abs(y).max(), 0.0, np.sign(y))
        crossings, length, moving = 0, 0.0, 0.0
        near = np.flatnonzero(y == 0.0)
        if near.size and near[0] > 0:
            quarters.append(float(r.t[near[0]] - r.t[0]))
        for part in stretches(r.t):
            away = np.flatnonzero(y[part]) + part.start
            turned = np.flatnonzero(np.diff(y[away]) != 0)
            crossings += turned.size
            length += float(r.t[part.stop - 1] - r.t[part.start])
            if turned.size:
                moving += float(r.t[away[turned[-1] + 1]] - r.t[part.start])
        if crossings >= 2:
            periods.append(2.0 * min(length, STILL * moving) / crossings)
    if periods or quarters:
        return float(np.median(periods or 4.0 * np.array(quarters)))
    return max(r.duration for r in recordings) / 10.0


def horizons_of(period: float, step: float, typical: float) -> tuple[float, ...]:
    """Window lengths: a quarter of a period (12 samples or more), then 2.4 and six times that.

    The last is half a second at least, where the recordings are that long.
    """
    first = max(0.25 * period, 12 * step)
    last = max(6.0 * first, 0.5)
    schedule = [first, np.sqrt(first * last), last]
    return tuple(float(min(h, 0.5 * typical)) for h in schedule)
