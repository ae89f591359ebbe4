"""Smooth bumps over short windows of a recording, by which equations are multiplied.

Source: Shinbrot (1957), Trans. ASME 79:67.
"""

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from tp_jax.estimation.windows import Prepared
from tp_jax.recordings import stretches

POWER = 4  # of the bump (1 - x^2)^4: three derivatives vanish at its ends
FEWEST = 12  # samples of a window
BLOCK = 1.0  # s


@dataclasses.dataclass(frozen=True)
class Bump:
    """One window of one recording.

    recording: index; span: samples; psi, first, second: (n,) the bump and its derivatives, each
    times the weights of the trapezoidal rule; block: which second of the data it begins in.
    """

    recording: int
    span: slice
    psi: np.ndarray
    first: np.ndarray
    second: np.ndarray
    block: int


def bumps(
    prepared: Sequence[Prepared], which: Sequence[int], length: float, overlap: float = 0.5
) -> Iterator[Bump]:
    """Bumps of `length` seconds all over some recordings; none reaches across a gap."""
    block = -1
    for r in which:
        t = prepared[r].t
        step = float(np.median(np.diff(t)))
        n = max(round(length / step), FEWEST)
        for part in stretches(t):
            last = -np.inf
            for first in range(part.start, part.stop - n + 1, max(round(n * (1.0 - overlap)), 1)):
                if t[first] - last >= BLOCK:
                    block, last = block + 1, t[first]
                span = slice(first, first + n)
                yield Bump(r, span, *_bump(t[span]), block)


def _bump(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    half = 0.5 * (t[-1] - t[0])
    x = (t - t[0]) / half - 1.0
    weights = np.gradient(t)
    weights[[0, -1]] *= 0.5
    q, p = 1.0 - x**2, POWER
    psi = q**p * weights
    first = -2.0 * p * x * q ** (p - 1) * weights
    second = (4.0 * p * (p - 1) * x**2 * q ** (p - 2) - 2.0 * p * q ** (p - 1)) * weights
    # By parts, of 1, x and x^2. The trapezoidal rule is not exact, and what it lets through of a
    # constant would count: a rider that has wound round stands at many radians.
    powers = x ** np.arange(3)[:, None]
    one, linear, _ = powers @ psi
    first = _with_moments(first, np.array([0.0, -one, -2.0 * linear]), powers, psi)
    second = _with_moments(second, np.array([0.0, 0.0, 2.0 * one]), powers, psi)
    return psi, first / half, second / half**2


def _with_moments(
    weights: np.ndarray, wanted: np.ndarray, powers: np.ndarray, psi: np.ndarray
) -> np.ndarray:
    """Weights with the moments wanted, changed by psi times a parabola."""
    shapes = powers * psi
    return weights + np.linalg.solve(powers @ shapes.T, wanted - powers @ weights) @ shapes
