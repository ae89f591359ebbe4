"""Thresholds that decide about the noise that residuals show, each with its unit and its reason."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class ResidualNoisePolicy:
    """Thresholds that decide about a colour.

    Attributes:
        harmonics: of a commanded drive's phase that belong to the motion.
        degree: of the polynomials that stand for it elsewhere, of a column alone and with a rider.
        rho: factors from lag to lag that are tried first. neighbours: correlations of neighbouring
            samples, in parts of what is possible with a factor. From the best of them a simplex
            search goes on.
        looked: samples, of evenly spread windows, on which that search is made: they tell a
            correlation to .02, and the whole costs a second.
        slowest: corner frequency of the noise's filter over the frequency of the motion, at least;
            slower noise and a gap that repeats every period cannot be told apart.
        trimmed: windows that leave more than this many medians are left out: transients.
        certain: fall of twice the negative log-likelihood from which noise is coloured: .0015 by a
            chi square of two numbers. Each of the tests of what is left (ten sources of errors in
            two sizes) alarms at .025 / 20; what passes for white up to a higher threshold they
            take for a gap.
        least: correlation of neighbours below which colour is not worth its trouble, unless it
            raises the error of a mean by `slow`.
        slow: see `least`.
        left: mean square that may be left, over that which high-order differences see under the
            same colour, for it to be noise.
        samples: below which residuals say nothing of a colour.
        apart: part, beyond three standard errors of so many samples, by which the mean square of a
            recording differs from that of all at most, for a rest to be of one size. What
            friction, springs and drives leave is another at another frequency.
        recordings: that are of one size, at least.
        short: error of a mean, over that of white noise, up to which a rest forgets itself soon.
        most: as `left`, of a rest of one size: an autoregression of two lags whose spectrum peaks
            halfway to the Nyquist frequency has up to twice what differences see.
    """

    harmonics: int = 8
    degree: tuple[int, int] = (5, 3)
    rho: tuple[float, ...] = (0.0, 0.3, 0.5, 0.7, 0.85, 0.93, 0.97)
    neighbours: tuple[float, ...] = (-0.7, -0.4, -0.15, 0.1, 0.3, 0.6, 0.85)
    looked: int = 4000
    slowest: float = 0.5
    trimmed: float = 3.0
    certain: float = 13.0
    least: float = 0.05
    slow: float = 1.1
    left: float = 1.25
    samples: int = 50
    apart: float = 0.1
    recordings: int = 3
    short: float = 2.0
    most: float = 2.5


POLICY = ResidualNoisePolicy()
