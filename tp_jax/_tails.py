"""Tails of the distributions that tests are read from.

By scipy.special, since importing scipy.stats takes half a second, a command's first.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

SMALL = 1e-200
"""A probability below which a series takes over, well before numbers underflow."""


def normal(z: ArrayLike) -> np.ndarray | float:
    """Probability that a standard normal exceeds z."""
    return special.ndtr(-np.asarray(z))


def chi_square_level(p: ArrayLike, dof: ArrayLike) -> np.ndarray | float:
    """Returns the value that chi squared exceeds with probability p."""
    return special.chdtri(dof, p)


def chi_square_below(x: ArrayLike, dof: ArrayLike) -> np.ndarray | float:
    """Probability that chi squared is less than x."""
    return special.chdtr(dof, x)


def chi_square_quantile(p: ArrayLike, dof: ArrayLike) -> np.ndarray | float:
    """Returns the value that chi squared is less than with probability p."""
    return 2.0 * special.gammaincinv(0.5 * np.asarray(dof), p)


def noncentral_chi_square(
    x: ArrayLike, dof: ArrayLike, noncentrality: ArrayLike
) -> np.ndarray | float:
    """Probability that chi squared with a noncentrality exceeds x."""
    return 1.0 - special.chndtr(x, dof, noncentrality)


def fisher(F: ArrayLike, dof: ArrayLike, below: ArrayLike) -> np.ndarray | float:
    """Probability that Fisher's F, of degrees of freedom above and below, exceeds a value."""
    return special.fdtrc(dof, below, F)


def student_level(p: ArrayLike, dof: ArrayLike) -> np.ndarray | float:
    """Returns the value that Student's t exceeds with probability p."""
    return -special.stdtrit(dof, p)


def log_chi_square(x: ArrayLike, dof: ArrayLike) -> np.ndarray | float:
    """Natural logarithm of the probability that chi squared exceeds x, however small that is."""
    half, shape = 0.5 * np.asarray(x, dtype=float), 0.5 * np.asarray(dof, dtype=float)
    p = special.gammaincc(shape, half)
    # Abramowitz and Stegun 6.5.32, where p underflows
    far = np.maximum(half, 1.0)
    series = 1.0 + (shape - 1.0) / far * (1.0 + (shape - 2.0) / far)
    log = -half + (shape - 1.0) * np.log(far) - special.gammaln(shape)
    small = p < SMALL
    return np.where(
        small, log + np.log(np.where(small, series, 1.0)), np.log(np.where(small, 1.0, p))
    )
