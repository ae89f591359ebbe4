"""The colour of the sensors' noise, from the recorded angles alone.

A filter in a sensor, a tracker that averages over frames or a converter's supply leave noise whose
neighbouring samples are correlated. Taken as white it makes every test of structure, every
interval and every probability too sure. Noise and motion are told apart by frequency: far above the
motion, what is left of its spectrum falls at least as fast as f^-6 (friction lets the acceleration
jump, and nothing less smooth is in a motion), where noise of a first-order filter falls as f^-2. So

    S(f) = c f^-6 + w + a / |1 - rho exp(-2 pi i f dt)|^2,   c, w, a >= 0, 0 <= rho < 1,

is fitted to the periodogram from some multiple of the motion's frequency up to the Nyquist
frequency, in bins of equal width in log f. Each bin enters with its median, so that the lines of a
drive's harmonics do not count. Below that band noise and motion cannot be separated: the colour is
continued there by its formula, and no correlation longer than the band shows is taken.

What a fitted model leaves says more (`tp_jax.estimation.residual_noise`): of noise below that band,
and where the sampling leaves no such band.

Source: Whittle (1953), Ark. Mat. 2, 423-434, for the likelihood of a spectrum; medians instead of
means follow Allen et al. (2012), Phys. Rev. D 85, 122006.
"""

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from tp_jax.recordings.colour import Colour, first_order
from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.recorded_run import RecordedRun


@dataclasses.dataclass(frozen=True)
class ColourPolicy:
    """Settings that decide about a colour.

    Attributes:
        above: multiples of the motion's frequency from which on its spectrum is a power law.
        band: part of the sampling rate below which the band has to begin.
        wide: part of the sampling rate below which it has to begin for noise slower than the band
            to be taken as fast as the band's lower end: in a narrow one it may be motion.
        bins: in which the periodogram is put. fewest: periodogram ordinates of a bin.
        samples: of a stretch, below which it says nothing of a spectrum.
        certain: fall of twice the negative log-likelihood that makes noise coloured; two numbers
            more, at a level of about 0.001, since colour costs every test some of its power.
        steepest: largest rho; beyond, the corner lies below the band in any recording at hand.
        jitter: part of a sampling interval by which times may be uneven.
    """

    above: float = 5.0
    band: float = 0.2
    wide: float = 0.06
    bins: int = 32
    fewest: int = 6
    samples: int = 128
    certain: float = 14.0
    steepest: float = 0.98
    jitter: float = 0.2


POLICY = ColourPolicy()


def noise_colour(
    recordings: Iterable[RecordedRun], name: str, period: float, policy: ColourPolicy = POLICY
) -> Colour:
    """Colour of one channel, from recordings of one sampling rate.

    Args:
        recordings: of about the same sampling rate.
        name: "phi1" or "phi2".
        period: of the motion [s].
        policy: what decides.

    Returns:
        White where the recordings are too short, too uneven, or do not say otherwise.
    """
    parts, steps = [], []
    for r in recordings:
        y = r.channels.get(name)
        if y is None or np.ptp(y) == 0.0:
            continue
        for part in stretches(r.t):
            t = r.t[part]
            if t.size < policy.samples:
                continue
            step = np.diff(t)
            if np.abs(step / np.median(step) - 1.0).max() > policy.jitter:
                continue
            parts.append(y[part])
            steps.append(float(np.median(step)))
    if not parts:
        return Colour()
    step = float(np.median(steps))
    lowest = policy.above / period
    found = _binned(parts, step, lowest, policy)
    if found is None:
        return Colour()
    f, level, weight = found
    white, coloured = (
        _fitted(f, level, weight, step, policy, with_colour) for with_colour in (0, 1)
    )
    if white.cost - coloured.cost < policy.certain:
        return Colour()
    _, w, a, rho = coloured.numbers
    if rho > np.exp(-2.0 * np.pi * lowest * step):
        # The corner frequency lies below the band, where the motion is: how far, nobody can say.
        if lowest > policy.wide / step:
            return Colour()
        rho = float(np.exp(-2.0 * np.pi * lowest * step))
    slow = a / (1.0 - rho**2)
    return first_order(rho, w / (w + slow), lowest)


def same_rate(recordings: Sequence[RecordedRun], ratio: float = 1.1) -> list[list[int]]:
    """Groups of recordings whose sampling intervals agree within a ratio, slowest last."""
    steps = np.array([np.median(np.diff(r.t)) for r in recordings])
    groups: list[list[int]] = []
    for i in np.argsort(steps, kind="stable").tolist():
        if groups and steps[i] <= ratio * steps[groups[-1][0]]:
            groups[-1].append(i)
        else:
            groups.append([i])
    return groups


def _binned(parts, step: float, lowest: float, policy: ColourPolicy):
    """Frequencies [Hz], mean spectral densities relative to white noise of variance 1, weights."""
    frequency, power = [], []
    for y in parts:
        f, p = _periodogram(y, step)
        inside = (f >= lowest) & (f <= 0.49 / step)
        frequency.append(f[inside])
        power.append(p[inside])
    f, p = np.concatenate(frequency), np.concatenate(power)
    if f.size < 4 * policy.fewest or lowest > policy.band / step:
        return None
    order = np.argsort(f, kind="stable")
    f, p = f[order], p[order]
    edges = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], policy.bins + 1)))
    edges[-1] = f.size
    rows = []
    begin = 0
    for end in edges[1:]:
        if end - begin < policy.fewest:
            continue
        part = p[begin:end]
        # median of an exponential is ln 2 of its mean; a Hann window correlates neighbours
        rows.append(
            (
                np.exp(np.log(f[begin:end]).mean()),
                np.median(part) / np.log(2.0),
                (end - begin) / HANN,
            )
        )
        begin = end
    table = np.array(rows)
    if len(table) < 5 or not (table[:, 1] > 0.0).all():
        return None
    return table[:, 0], table[:, 1], table[:, 2]


def _periodogram(y: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz], and spectral densities relative to white noise of variance 1.

    Of what a straight line leaves, under a Hann window.
    """
    n = len(y)
    x = np.linspace(-1.0, 1.0, n)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    rest = y - y.mean() - x * (x @ y) / (x @ x)
    power = np.abs(np.fft.rfft(window * rest)) ** 2 / (window @ window)
    return np.fft.rfftfreq(n, step), power


HANN = 1.5 * 2.08  # ordinates of a Hann periodogram's median that say as much as one of a mean


@dataclasses.dataclass(frozen=True)
class _Spectrum:
    cost: float
    numbers: tuple[float, float, float, float]


def _fitted(f, level, weight, step: float, policy: ColourPolicy, with_colour: int) -> _Spectrum:
    """Twice the negative log-likelihood of gamma-distributed bins, and c, w, a, rho."""
    from scipy import optimize  # here, so that recording does not wait for it

    slope = (f / f[0]) ** -6.0
    floor = float(np.median(level[-max(len(level) // 4, 1) :]))
    unit = max(floor, 1e-300)

    turn = np.cos(2.0 * np.pi * f * step)

    def parts(x):
        """Motion, white and coloured noise, and what follows from the last number."""
        found = [unit * np.exp(x[0]) * slope, np.full_like(f, unit * np.exp(x[1]))]
        if with_colour:
            rho = policy.steepest / (1.0 + np.exp(-x[3]))
            below = 1.0 - 2.0 * rho * turn + rho**2
            coloured = unit * np.exp(x[2]) / below
            by_rho = coloured * 2.0 * (turn - rho) / below
            found += [coloured, by_rho * rho * (1.0 - rho / policy.steepest)]
        return found

    def cost(x):
        """Returns the cost and its gradient."""
        found = parts(x)
        s = sum(found[:3])
        value = 2.0 * float(np.sum(weight * (np.log(s / level) + level / s - 1.0)))
        return value, [2.0 * float(np.sum(weight * (s - level) / s**2 * d)) for d in found]

    best = None
    starts = (
        [(-3.0, 0.0)]
        if not with_colour
        else [(-3.0, -1.0, -1.0, g) for g in (-1.0, 0.5, 2.0)] + [(-3.0, -6.0, 0.0, 0.0)]
    )
    bounds = [(-25.0, 25.0), (-12.0, 5.0), (-25.0, 5.0), (-4.0, 8.0)][: 2 + 2 * with_colour]
    for x0 in starts:
        found = optimize.minimize(cost, x0, jac=True, method="L-BFGS-B", bounds=bounds)
        if best is None or found.fun < best.fun:
            best = found
    assert best is not None
    x = best.x
    rho = policy.steepest / (1.0 + np.exp(-x[3])) if with_colour else 0.0
    a = unit * float(np.exp(x[2])) if with_colour else 0.0
    return _Spectrum(
        float(best.fun), (unit * np.exp(x[0]), unit * float(np.exp(x[1])), a, float(rho))
    )
