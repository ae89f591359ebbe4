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

Where the sampling leaves no such band, `tp_jax.estimation.residual_noise` looks at what a model
leaves instead.

Source: Whittle (1953), Ark. Mat. 2, 423-434, for the likelihood of a spectrum; medians instead of
means follow Allen et al. (2012), Phys. Rev. D 85, 122006.
"""

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.recording import Recording


@dataclasses.dataclass(frozen=True)
class ColourPolicy:
    """What decides about a colour.

    Attributes:
        above: multiples of the motion's frequency from which on its spectrum is a power law.
        band: part of the sampling rate below which the band has to begin.
        wide: part of the sampling rate below which it has to begin for white to be certain: of
            slower noise a narrow band shows the same as of white noise.
        bins: in which the periodogram is put. fewest: periodogram ordinates of a bin.
        samples: of a stretch, below which it says nothing of a spectrum.
        order: of the autoregression that whitens; at 250 Hz and a correlation of ten samples beside
            as much white noise the residual correlation is then below 0.01.
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
    order: int = 10
    certain: float = 14.0
    steepest: float = 0.98
    jitter: float = 0.2


POLICY = ColourPolicy()


@dataclasses.dataclass(frozen=True)
class Colour:
    """Noise of one channel at one sampling rate, up to its level.

    Attributes:
        ar: (p,) coefficients of the autoregression with the noise's autocorrelation; empty: white.
        correlation: (p,) its autocorrelation at lags of 1 to p samples.
        white: part of the variance that is white.
        rho: correlation of neighbouring samples of the other part.
        lowest: frequency [Hz] below which noise and motion could not be told apart; 0 where the
            data alone do not say what the noise is.
        of_residuals: whether it was found in what a model leaves, not in the data alone.
        excess: standard deviation over that of the same noise if it were white and had the level
            that high-order differences see.
    """

    ar: tuple[float, ...] = ()
    correlation: tuple[float, ...] = ()
    white: float = 1.0
    rho: float = 0.0
    lowest: float = 0.0
    excess: float = 1.0
    of_residuals: bool = False

    @property
    def slow(self) -> float:
        """Error of a mean over many samples, over that of as many with white noise."""
        if self.is_white:
            return 1.0
        return float(np.sqrt(self.white + (1.0 - self.white) * (1.0 + self.rho) / (1.0 - self.rho)))

    @property
    def is_white(self) -> bool:
        """Whether neighbouring samples are uncorrelated."""
        return not self.ar

    def whiten(self, x: np.ndarray, axis: int = 0) -> np.ndarray:
        """Rows that are uncorrelated and of unit variance where those of x are this noise, scaled.

        Exact for an autoregression: the first p rows are decorrelated by their own covariance.

        Args:
            x: consecutive samples of a stretch along an axis, in units of the noise's standard
                deviation.
            axis: of the samples.
        """
        if self.is_white or not x.size:
            return x
        from scipy import signal  # a second of loading that white noise need not wait for

        n = x.shape[axis]
        taps = np.concatenate([[1.0], -np.array(self.ar)]) / np.sqrt(self.innovation)
        # of a denominator of one number SciPy takes another way, by a loop over rows in Python
        out = signal.lfilter(taps, [1.0, 0.0], x, axis=axis)
        first = min(len(self.ar), n)
        head = np.linalg.inv(_cholesky(self.correlation, first))
        part = np.take(x, range(first), axis=axis)
        where = [slice(None)] * x.ndim
        where[axis] = slice(first)
        out[tuple(where)] = np.moveaxis(np.tensordot(head, part, axes=(1, axis)), 0, axis)
        return out

    @property
    def innovation(self) -> float:
        """Variance of what an autoregression cannot predict, in units of the whole."""
        return 1.0 - float(np.dot(self.ar, self.correlation))


def _cholesky(correlation: Sequence[float], n: int) -> np.ndarray:
    return np.linalg.cholesky(_toeplitz(correlation[: n - 1]))


def _toeplitz(correlation: Sequence[float] | np.ndarray) -> np.ndarray:
    """Correlation matrix of samples in a row, from that at lags of 1 and more."""
    row = np.concatenate([[1.0], correlation])
    at = np.arange(row.size)
    return row[np.abs(at[:, None] - at)]


def noise_colour(
    recordings: Iterable[Recording], name: str, period: float, policy: ColourPolicy = POLICY
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
        return Colour(lowest=lowest if lowest < policy.wide / step else 0.0)
    _, w, a, rho = coloured.numbers
    if rho > np.exp(-2.0 * np.pi * lowest * step):
        # The corner frequency lies below the band, where the motion is: how far, nobody can say.
        if lowest > policy.wide / step:
            return Colour()
        rho = float(np.exp(-2.0 * np.pi * lowest * step))
    slow = a / (1.0 - rho**2)
    return first_order(rho, w / (w + slow), lowest, policy.order)


def first_order(rho: float, white: float, lowest: float = 0.0, order: int = POLICY.order) -> Colour:
    """White noise and that of a first-order filter together.

    Args:
        rho: correlation of neighbouring samples of the latter. white: part of the former in the
            variance. lowest: see `Colour`. order: of the autoregression.
    """
    correlation = (1.0 - white) * rho ** np.arange(1, order + 1)
    ar = np.linalg.solve(_toeplitz(correlation[:-1]), correlation)
    # differences of high order see what is near the Nyquist frequency
    seen = white + (1.0 - white) * (1.0 - rho) / (1.0 + rho)
    return Colour(
        tuple(map(float, ar)), tuple(map(float, correlation)), float(white), float(rho),
        float(lowest), float(1.0 / np.sqrt(seen)),
    )  # fmt: skip


def same_rate(recordings: Sequence[Recording], ratio: float = 1.1) -> list[list[int]]:
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
    from scipy import signal  # here, so that recording does not wait for it

    frequency, power = [], []
    for y in parts:
        f, p = signal.periodogram(y, 1.0 / step, window="hann", detrend="linear")
        inside = (f >= lowest) & (f <= 0.49 / step)
        frequency.append(f[inside])
        power.append(p[inside] * 0.5 / step)  # one-sided density to variance per sample
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
        rows.append((np.exp(np.log(f[begin:end]).mean()), np.median(part) / np.log(2.0),
                     (end - begin) / HANN))  # fmt: skip
        begin = end
    table = np.array(rows)
    if len(table) < 5 or not (table[:, 1] > 0.0).all():
        return None
    return table[:, 0], table[:, 1], table[:, 2]


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

    def spectrum(x):
        c, w = np.exp(x[0]), np.exp(x[1])
        out = c * slope + w
        if with_colour:
            rho = policy.steepest / (1.0 + np.exp(-x[3]))
            out = out + np.exp(x[2]) / (1.0 - 2.0 * rho * np.cos(2 * np.pi * f * step) + rho**2)
        return unit * out

    def cost(x):
        s = spectrum(x)
        return 2.0 * float(np.sum(weight * (np.log(s / level) + level / s - 1.0)))

    best = None
    starts = [(-3.0, 0.0)] if not with_colour else [
        (-3.0, -1.0, -1.0, g) for g in (-1.0, 0.5, 2.0)
    ] + [(-3.0, -6.0, 0.0, 0.0)]  # fmt: skip
    bounds = [(-25.0, 25.0), (-12.0, 5.0), (-25.0, 5.0), (-4.0, 8.0)][: 2 + 2 * with_colour]
    for x0 in starts:
        found = optimize.minimize(cost, x0, method="L-BFGS-B", bounds=bounds)
        if best is None or found.fun < best.fun:
            best = found
    assert best is not None
    x = best.x
    rho = policy.steepest / (1.0 + np.exp(-x[3])) if with_colour else 0.0
    a = unit * float(np.exp(x[2])) if with_colour else 0.0
    return _Spectrum(
        float(best.fun), (unit * np.exp(x[0]), unit * float(np.exp(x[1])), a, float(rho))
    )
