"""Normal equations of a sum of squares, priors apart, and everything that is asked of them.

Once the windows' states are eliminated (`elimination`), a sum of squares is quadratic in the
unknowns: gradient and information are all that is left of it. A step within bounds, the covariance
of the unknowns, and what is left for some of them once the others are re-optimised are the same
few lines wherever they are needed, and they stand here.

There are two inverses, for two questions. How much does one unknown move when another does
(`scaled_inverse`)? A direction without information moves nothing. How well is an unknown known
(`covariance_of`)? Along such a direction not at all, so that its variance is huge; by the first
inverse it would be known exactly.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.bounded_step import Step, bounded_step

CUT = 1e-12
"""Part of the largest eigenvalue, unknowns scaled to a unit diagonal, below which an eigenvalue is
rounding: differentiation and elimination leave errors of some 1e-13."""

UNKNOWN = 1e-14
"""Part of the largest eigenvalue that stands for none, where the variance is asked for: an sd of
ten million times that of the best known direction."""


@dataclasses.dataclass(frozen=True)
class NormalEquations:
    """The sum of squares `cost + 2 g'd + d'(H + P) d` in changes d of the unknowns.

    Attributes:
        g: (u,) half the gradient, with the priors' part.
        H: (u, u) information of the data.
        prior: (u,) information before any data, by unknown: the diagonal of P.
    """

    g: np.ndarray
    H: np.ndarray
    prior: np.ndarray

    @property
    def information(self) -> np.ndarray:
        """Returns the information (u, u) of data and priors."""
        return self.H + np.diag(self.prior)

    def part(self, kept: Sequence[int] | np.ndarray) -> "NormalEquations":
        """The equations of some unknowns, the others held.

        Args:
            kept: (k,) places, or (u,) bool.
        """
        kept = np.asarray(kept)
        return NormalEquations(self.g[kept], self.H[kept][:, kept], self.prior[kept])

    def step(self, lower: np.ndarray, upper: np.ndarray, damping: float = 0.0) -> Step:
        """The step within bounds, of unknowns in coordinates of like size: see `bounded_step`."""
        return bounded_step(self.g, self.information, lower, upper, damping)

    def covariance(self) -> np.ndarray:
        """The covariance (u, u) of the unknowns: see `covariance_of`."""
        return covariance_of(self.information)


def scaled_inverse(information: np.ndarray, cut: float = CUT, telling: float = 0.0) -> np.ndarray:
    """Pseudo-inverse of an information or covariance matrix (u, u), scaled to a unit diagonal.

    Scaling makes the cut independent of units. For steps and projections: a direction without
    information does not move. Its variance is another matter (`covariance_of`).

    Args:
        information: symmetric, positive semidefinite.
        cut: eigenvalues below this part of the largest count as zero.
        telling: an unknown of which less than this part of the best known one's root is known
            counts as one of which nothing is.
    """
    scale = np.sqrt(np.maximum(np.diag(information), 0.0))
    live = scale > max(telling * scale.max(initial=0.0), 1e-150)
    out = np.zeros(information.shape)
    if live.any():
        unit = np.outer(scale[live], scale[live])
        core = information[np.ix_(live, live)] / unit
        out[np.ix_(live, live)] = np.linalg.pinv(core, rcond=cut, hermitian=True) / unit
    return out


def efficient_inverse(V: np.ndarray) -> np.ndarray:
    """The same of efficient information (q, q), of which projection leaves fewer digits."""
    return scaled_inverse(V, cut=1e-9, telling=1e-12)


def covariance_of(information: np.ndarray) -> np.ndarray:
    """Covariance (u, u) by the inverse of information (u, u), scaled first.

    Huge rather than infinite along directions without any information.
    """
    least = max(1e-30 * float(np.diag(information).max(initial=0.0)), 1e-200)
    d = np.sqrt(np.maximum(np.diag(information), least))
    value, vector = np.linalg.eigh(information / np.outer(d, d))
    value = np.maximum(value, UNKNOWN * max(value.max(initial=0.0), 1e-300))
    return (vector / value) @ vector.T / np.outer(d, d)


def projected(H: np.ndarray, kept: Sequence[int], out: Sequence[int]) -> np.ndarray:
    """Information (k, k) about some unknowns once others are re-optimised.

    Args:
        H: (u, u) information. kept, out: places; what is in neither is held.
    """
    left = H[np.ix_(kept, kept)]
    if len(out):
        cross = H[np.ix_(kept, out)]
        left = left - cross @ scaled_inverse(H[np.ix_(out, out)]) @ cross.T
    return 0.5 * (left + left.T)
