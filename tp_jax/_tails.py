"""Tails of the distributions that tests are read from.

By scipy.special, since importing scipy.stats takes half a second, a command's first.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy import special


def normal(z: ArrayLike) -> np.ndarray:
    """Probability that a standard normal exceeds z."""
    return special.ndtr(-np.asarray(z))


def chi_square_level(p: ArrayLike, dof: ArrayLike) -> np.ndarray:
    """What chi squared exceeds with probability p."""
    return special.chdtri(dof, p)


def chi_square_below(x: ArrayLike, dof: ArrayLike) -> np.ndarray:
    """Probability that chi squared is less than x."""
    return special.chdtr(dof, x)


def chi_square_quantile(p: ArrayLike, dof: ArrayLike) -> np.ndarray:
    """What chi squared is less than with probability p."""
    return 2.0 * special.gammaincinv(0.5 * np.asarray(dof), p)


def noncentral_chi_square(x: ArrayLike, dof: ArrayLike, noncentrality: ArrayLike) -> np.ndarray:
    """Probability that chi squared with a noncentrality exceeds x."""
    return 1.0 - special.chndtr(x, dof, noncentrality)


def fisher(F: ArrayLike, dof: ArrayLike, below: ArrayLike) -> np.ndarray:
    """Probability that Fisher's F, of degrees of freedom above and below, exceeds a value."""
    return special.fdtrc(dof, below, F)


def student_level(p: ArrayLike, dof: ArrayLike) -> np.ndarray:
    """What Student's t exceeds with probability p."""
    return -special.stdtrit(dof, p)
