"""The level of the sensors' noise, from the recorded angles alone.

Differences of order m wipe out whatever a polynomial of degree m - 1 can follow within m + 1
samples, and leave the noise. Low orders leave some of the motion too; the motion's share falls
with every order where the sampling resolves it, the noise's stays. The order is therefore raised
until the level no longer falls by more than its own sampling error. A robust scale keeps the few
samples near a kink (where friction turns round) out of it. Of coloured noise a difference sees more
or less than of white noise, by a factor that the colour gives (`Colour.seen`).
"""

import dataclasses
from collections.abc import Sequence
from math import comb

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tp_jax.recordings.colour import Colour
from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.noise_colour import same_rate
from tp_jax.recordings.recorded_run import RecordedRun

ORDERS = range(2, 9)

COARSE = 2.0
"""Steps of a channel, in standard deviations of its noise, that hide it."""

_CLIP = 3.0  # standard deviations
_CLIPPED_VARIANCE = 0.97333  # of a standard normal, given that it lies within _CLIP


@dataclasses.dataclass(frozen=True)
class LevelPolicy:
    """Conditions under which a recording has a noise level of its own.

    Attributes:
        apart: part by which its standard deviation differs from that of the recordings at its
            rate; less moves no decision, and the common level is the better known.
        errors: standard errors by which it differs.
        rounded: steps of the readings that a level of its own has to exceed, where steps hide the
            noise: rounding alone makes next to nothing of it in the middle of a step, and half a
            step or a little more at its edge, wherever the motion happens to be.
    """

    apart: float = 0.15
    errors: float = 5.0
    rounded: float = 0.6


POLICY = LevelPolicy()


def noise_level(t: np.ndarray, y: np.ndarray, colour: Colour | None = None) -> float:
    """Standard deviation of the measurement noise of one channel.

    Never below quantum / sqrt(12), the error of rounding, where y comes in steps. Noise of a
    band narrower than the sampling looks like motion and is not counted, unless its colour is
    known. Nothing is compared across a gap, and stretches of fewer than 4 samples are not used.

    Args:
        t: (n,) rising times [s]; they need not be uniform.
        y: (n,) values, n >= 10 for all orders to be used.
        colour: of the noise; white if None.

    Returns:
        The level in y's unit; 0 for a constant.

    Raises:
        ValueError: fewer than 4 samples without a gap.
    """
    return _level(t, y, colour)[0]


def noise_level_and_error(t: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Computes `noise_level` and its relative standard error."""
    return _level(t, y, None)


def _level(t: np.ndarray, y: np.ndarray, colour: Colour | None) -> tuple[float, float]:
    """Level of one channel, and its relative standard error."""
    t, y = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
    parts = stretches(t)
    longest = max(part.stop - part.start for part in parts)
    if longest < 4:
        raise ValueError(
            f"A noise level needs 4 samples or more, but there are {longest} without a gap."
        )
    y0 = y - np.median(y)
    by_order: dict[int, list[np.ndarray]] = {}
    for part in parts:
        for order, difference in _differences(t[part], y0[part]):
            by_order.setdefault(order, []).append(difference)
    levels, errors = [], []
    step = quantum(y)
    for order in sorted(by_order):
        difference = np.concatenate(by_order[order])
        level = _robust_scale(difference, step) / (1.0 if colour is None else colour.seen(order))
        levels.append(level)
        errors.append(_relative_error(order, difference.size))
    # The first order, not the smallest level: the least of several estimates is biased.
    settled = next(i for i, x in enumerate(levels) if x - min(levels[i:]) <= x * errors[i])
    return max(levels[settled], step / float(np.sqrt(12.0))), errors[settled]


def noise_levels(
    recordings: Sequence[RecordedRun],
    colours: Sequence[tuple[Colour, Colour]] | None = None,
    policy: LevelPolicy = POLICY,
) -> np.ndarray:
    """Noise (r, 2) of both channels in every recording [rad]; 0 where one is missing or constant.

    Recordings at one rate share the median of the fitted ones' variances, which one disturbed
    recording does not move; a recording whose level clearly differs, by more than rounding makes,
    has its own.

    Args:
        recordings: of a campaign.
        colours: of both channels in each; white if None.
        policy: what counts as clearly different.
    """
    out = np.zeros((len(recordings), 2))
    for group in same_rate(recordings):
        for c, name in enumerate(("phi1", "phi2")):
            own = {}
            for i in group:
                y = recordings[i].channels.get(name)
                if y is not None and np.ptp(y) > 0.0:
                    colour = None if colours is None else colours[i][c]
                    own[i] = _level(recordings[i].t, y, colour)
            fitted = [i for i in own if not recordings[i].held_out] or list(own)
            if not fitted:
                continue
            common = float(np.sqrt(np.median([own[i][0] ** 2 for i in fitted])))
            for i in group:
                level, error = own.get(i, (common, 0.0))
                apart = max(policy.apart, policy.errors * error)
                differs = abs(level - common) > apart * min(level, common)
                if differs and i in own:
                    readings = recordings[i].channels[name]
                    step = quantum(readings) if steps_hide(readings, common) else 0.0
                    differs = step == 0.0 or level > policy.rounded * step
                out[i, c] = level if differs else common
    return out


def quantum(y: np.ndarray) -> float:
    """The step of a channel that comes in steps; 0 where it does not, or where it is constant.

    Args:
        y: (n,) values.
    """
    values = np.unique(y)
    if 2 * values.size > y.size:
        return 0.0  # hardly a value repeats: a step, if any, shows as noise in the differences
    steps = np.diff(values)
    # One reading converted in two ways differs in the last digits: no step.
    steps = steps[steps > 1e-9 * np.abs(values).max()]
    if not steps.size:
        return 0.0
    step = float(steps.min())
    multiples = steps[steps < 10.0 * step] / step
    on_grid = np.abs(multiples - np.round(multiples)) < 0.1  # a file may round the readings again
    return step if np.mean(on_grid) > 0.9 else 0.0


def steps_hide(readings: np.ndarray, level: float) -> bool:
    """True where the steps of a channel's readings [rad] hide its noise: rounding then goes with
    the motion in part."""
    return bool(quantum(readings) > COARSE * level)


def is_coarse(recording: RecordedRun) -> bool:
    """True where steps hide the noise of one of a recording's angles."""
    angles = recording.channels.values()
    return any(steps_hide(y, noise_level(recording.t, y)) for y in angles)


def _differences(t: np.ndarray, y: np.ndarray):
    """Divided differences of each order, scaled to the noise's own standard deviation.

    On a uniform grid they are the differences divided by sqrt(binom(2m, m)). On another one
    the weights follow the times, so that jitter lets no motion through. Fewer than 4 samples
    give none.
    """
    if t.size < 4:
        return
    x = (t - t[0]) / np.median(np.diff(t))
    weights = np.ones((t.size, 1))
    for order in range(1, min(ORDERS.stop - 1, t.size - 2) + 1):
        width = (x[order:] - x[:-order])[:, None]
        upper = np.pad(weights[1:] / width, ((0, 0), (1, 0)))
        lower = np.pad(weights[:-1] / width, ((0, 0), (0, 1)))
        weights = upper - lower
        if order in ORDERS:
            value = np.einsum("nw,nw->n", weights, sliding_window_view(y, order + 1))
            yield order, value / np.sqrt(np.einsum("nw,nw->n", weights, weights))


def _robust_scale(values: np.ndarray, step: float = 0.0) -> float:
    """Standard deviation of the bulk: clipped at three of them, from the MAD on.

    The MAD alone would do, but its sampling error is 1.6 times as large. Differences of readings
    that come in steps are few numbers, of which the MAD is one and may be far below the scale (zero
    but for its last digits, where a body nearly at rest is read coarsely), so that the clipping
    would begin too low: it begins at half a step at least, which no outlier moves.

    Args:
        values: differences, scaled to the standard deviation of the noise.
        step: of the readings, 0 where they come in none.
    """
    size = np.abs(values)
    scale = 1.4826 * float(np.median(size))
    scale = max(scale, 0.5 * step)
    if scale == 0.0:
        # More than half the differences vanish: a coarse reading of a body nearly at rest.
        bulk = size[size <= np.quantile(size, 0.99)]
        return float(np.sqrt(np.mean(bulk**2)))
    for _ in range(5):
        bulk = size[size <= _CLIP * scale]
        scale = float(np.sqrt(np.mean(bulk**2) / _CLIPPED_VARIANCE))
    return scale


def _relative_error(order: int, n: int) -> float:
    """Standard error of the scale over the scale; neighbouring differences are correlated."""
    return float(np.sqrt(comb(4 * order, 2 * order) / (2.0 * n)) / comb(2 * order, order))
