"""Correlated noise of a sensor: an ARMA(1, 1) process, its autocovariance and its whitening.

Its autocorrelation is c rho^(k-1) at lags k = 1, 2, ...: white noise and that of a first-order
filter together (0 < c < rho), an autoregression (c = rho), and a moving average (rho = 0; c < 0
where neighbouring readings differ by more than independent ones would, as after a converter that
makes up for its last rounding). The process exists where its spectrum is nowhere negative:

    -(1 - rho) / 2 <= c <= (1 + rho) / 2.

Source: Brockwell, Davis (1991), Time Series: Theory and Methods, 2nd ed., sections 3.1 and 5.3.
"""

import dataclasses
import functools
from collections.abc import Sequence
from math import comb

import numpy as np

ORDER = 10
"""Lags and autoregressive coefficients that are reported."""

EDGE = 0.99
"""Part of the way to a spectrum with a zero that a colour may go: beyond, whitening would divide
by next to nothing."""

HEAD = (8, 256)
"""Samples whitened by their own covariance before a window's filter has settled, least and most."""

TOGETHER = 32
"""Rows that are whitened at once; a few more or less cost the same."""

SETTLED = 1e-6
"""Relative error of a window's innovation variance at which the filter counts as settled."""


@dataclasses.dataclass(frozen=True)
class Colour:
    """Noise of one channel at one sampling rate, up to its level.

    Attributes:
        neighbours: correlation of neighbouring samples, c above; 0: white.
        rho: factor from one lag to the next.
        lowest: frequency [Hz] below which noise and motion could not be told apart; 0 where the
            data alone do not say what the noise is.
        of_residuals: whether it was found in what a model leaves, not in the data alone.
    """

    neighbours: float = 0.0
    rho: float = 0.0
    lowest: float = 0.0
    of_residuals: bool = False

    @property
    def is_white(self) -> bool:
        """True if neighbouring samples are uncorrelated."""
        return self.neighbours == 0.0

    @property
    def white(self) -> float:
        """Part of the variance that is white; 0 of noise with negatively correlated neighbours."""
        if self.is_white:
            return 1.0
        return float(np.clip(1.0 - self.neighbours / self.rho, 0.0, 1.0)) if self.rho else 0.0

    @property
    def correlation(self) -> tuple[float, ...]:
        """Autocorrelation at lags of 1 to `ORDER` samples; empty: white."""
        return () if self.is_white else tuple(map(float, self.covariance(ORDER + 1)[1:]))

    @property
    def ar(self) -> tuple[float, ...]:
        """Coefficients of the autoregression of order `ORDER` with its autocorrelation."""
        if self.is_white:
            return ()
        own = self.covariance(ORDER + 1)
        return tuple(map(float, np.linalg.solve(_toeplitz(own[:-1]), own[1:])))

    @property
    def slow(self) -> float:
        """Error of a mean over many samples, over that of as many with white noise."""
        return float(np.sqrt(1.0 + 2.0 * self.neighbours / (1.0 - self.rho)))

    @property
    def excess(self) -> float:
        """Standard deviation over that of white noise as dense at the Nyquist frequency."""
        return float(1.0 / np.sqrt(1.0 - 2.0 * self.neighbours / (1.0 + self.rho)))

    def covariance(self, n: int) -> np.ndarray:
        """Autocovariance (n,) at lags of 0 to n - 1 samples, variance 1."""
        out = self.neighbours * self.rho ** np.maximum(np.arange(n) - 1.0, 0.0)
        out[:1] = 1.0
        return out

    def seen(self, order: int) -> float:
        """Standard deviation of a difference of some order, scaled to that of white noise."""
        lags = np.arange(1, order + 1)
        weight = np.array([(-1.0) ** k * comb(2 * order, order + int(k)) for k in lags])
        own = self.covariance(order + 1)[1:]
        return float(np.sqrt(1.0 + 2.0 * (weight @ own) / comb(2 * order, order)))

    def whiten(self, x: np.ndarray, axis: int = 0) -> np.ndarray:
        """Rows that are uncorrelated and of unit variance where those of x are this noise.

        Exact: the first rows are decorrelated by their own covariance, until the filter of the
        innovations has settled.

        Args:
            x: consecutive samples of a stretch along an axis, in units of the noise's standard
                deviation.
            axis: of the samples.
        """
        if self.is_white or not x.size:
            return x
        theta, innovation = _innovations(self.neighbours, self.rho)
        head = _head(self.neighbours, self.rho)
        x = np.moveaxis(x, axis, 0)
        rows = np.ascontiguousarray(x).reshape(len(x), -1)
        out = np.empty(rows.shape)
        k = min(len(head), len(rows))
        out[:k] = head[:k, :k] @ rows[:k]
        rest = out[k:]
        np.multiply(rows[k - 1 : -1], -self.rho, out=rest)
        rest += rows[k:]
        rest /= innovation
        if theta:
            # e_t + theta e_(t-1) = x_t - rho x_(t-1), some rows at a time: one by one takes as many
            # calls as there are rows, all at once a matrix of as many rows squared.
            memory = _memory(theta)
            for begin in range(0, len(rest), TOGETHER):
                part = rest[begin : begin + TOGETHER]
                part[0] -= theta * out[k + begin - 1]
                part[:] = memory[: len(part), : len(part)] @ part
        return np.moveaxis(out.reshape(x.shape), 0, axis)

    def innovations(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Weights (n,) of the recursion whose rows are those of `whiten`.

        e_t = x_t - a_t x_(t-1) - b_t e_(t-1), and s_t e_t is white and of unit variance: for what
        goes through the samples one by one. Returns a, b, s.
        """
        a, b, variance = np.zeros(n), np.zeros(n), np.ones(n)
        if self.is_white:
            return a, b, variance
        a[1:] = self.rho
        total, lag = (
            1.0 + self.rho**2 - 2.0 * self.rho * self.neighbours,
            self.neighbours - self.rho,
        )
        for t in range(1, n):
            b[t] = lag / variance[t - 1]
            variance[t] = total - b[t] * lag
        return a, b, 1.0 / np.sqrt(variance)

    def log_determinant(self, n: int) -> float:
        """Logarithm of the determinant of the covariance of n samples, variance 1."""
        if self.is_white:
            return 0.0
        diagonal = np.diag(_head(self.neighbours, self.rho))[:n]
        left = max(n - len(diagonal), 0)
        settled = np.log(_innovations(self.neighbours, self.rho)[1])
        return float(2.0 * (left * settled - np.log(diagonal).sum()))


def limits(rho: float) -> tuple[float, float]:
    """Least and largest correlation of neighbours of a process with this factor."""
    return -0.5 * EDGE * (1.0 - rho), 0.5 * EDGE * (1.0 + rho)


def first_order(rho: float, white: float, lowest: float = 0.0) -> Colour:
    """White noise and that of a first-order filter together.

    Args:
        rho: correlation of neighbouring samples of the latter. white: part of the former in the
            variance. lowest: see `Colour`.
    """
    return Colour(float((1.0 - white) * rho), float(rho), float(lowest))


def _innovations(c: float, rho: float) -> tuple[float, float]:
    """Coefficient of the moving average and standard deviation of the innovations."""
    variance, lag = 1.0 + rho**2 - 2.0 * rho * c, c - rho
    if abs(lag) < 1e-12:  # an autoregression
        return 0.0, float(np.sqrt(variance))
    q = lag / variance
    theta = (1.0 - np.sqrt(max(1.0 - 4.0 * q**2, 0.0))) / (2.0 * q)
    return float(theta), float(np.sqrt(lag / theta))


def _memory(theta: float) -> np.ndarray:
    """Lower triangular matrix that takes a moving average out of some consecutive rows."""
    at = np.arange(TOGETHER)
    back = np.maximum(at[:, None] - at, 0)
    return np.tril((-theta) ** back)


@functools.lru_cache(maxsize=64)
def _head(c: float, rho: float) -> np.ndarray:
    """Lower triangular matrix that whitens the first samples of a stretch."""
    theta = abs(_innovations(c, rho)[0])
    needed = np.log(SETTLED) / (2.0 * np.log(theta)) if theta > 0.0 else 0.0
    n = int(np.clip(np.ceil(needed), *HEAD))
    return np.linalg.inv(np.linalg.cholesky(_toeplitz(Colour(c, rho).covariance(n))))


def _toeplitz(row: Sequence[float] | np.ndarray) -> np.ndarray:
    """Symmetric matrix of autocovariances."""
    at = np.arange(len(row))
    return np.asarray(row)[np.abs(at[:, None] - at)]
