"""Detectable sizes, and effects that are tied, as the linearisation shows them for the data."""

import functools
import math
from collections.abc import Sequence

import numpy as np
from scipy import optimize

from tp_jax import _tails as tails
from tp_jax.effects import Law
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.screen import Scored, Screen

POWER, FAMILY_WISE = 0.95, 0.05
TIED = 0.95  # |cos| of projected directions above which two effects are not told apart


@functools.cache
def needed_noncentrality(q: int, tests: int) -> float:
    """Noncentrality at which a chi-square test of q amplitudes, one of many, has the power."""
    critical = tails.chi_square_level(FAMILY_WISE / tests, q)

    def short(noncentrality: float) -> float:
        return float(tails.noncentral_chi_square(critical, q, noncentrality)) - POWER

    return float(optimize.root_scalar(short, bracket=(1e-3, 1e4), method="brentq").root)


def minimum_detectable(scored: Scored, tests: int, inflation: float) -> float | None:
    """Size found with the power, in the least detectable direction of the amplitudes.

    None where no size does or where it lies beyond the physical range.

    Args:
        scored: the effect.
        tests: number of candidates tested at once.
        inflation: what the residuals' variance is above the noise (chi2/dof).
    """
    V = scored.V
    scale = np.sqrt(np.maximum(np.diag(V), 0.0))
    if not (scale > 0).all():
        return None
    value = np.linalg.eigvalsh(V)
    if value[0] <= 1e-12 * value[-1]:
        return None
    needed = needed_noncentrality(V.shape[0], tests) * max(inflation, 1.0)
    size = float(np.sqrt(needed / value[0]))
    return size if size <= np.abs(scored.limits).max() else None


def middle_detectable(several: Sequence[Scored], tests: int, inflation: float) -> float | None:
    """The size that is found at half of an effect's shapes at least: the upper median of theirs.

    Args:
        several: the effect, at one set of shape constants or at more.
        tests, inflation: see `minimum_detectable`.
    """
    sizes = [minimum_detectable(s, tests, inflation) for s in several]
    middle = sorted(math.inf if x is None else x for x in sizes)[len(sizes) // 2]
    return middle if math.isfinite(middle) else None


def cosine(screen: Screen, a: Scored, b: Scored) -> float:
    """Largest |cos| between projected directions of two effects (canonical correlation)."""
    return _cosine(screen, a, b, _inverse_root(screen, a), _inverse_root(screen, b))


def _cosine(screen: Screen, a: Scored, b: Scored, of_a: np.ndarray, of_b: np.ndarray) -> float:
    """The same from the roots of the inverse information of each."""
    cross = of_a @ screen.information[a.rows, b.rows] @ of_b
    if not cross.size:
        return 0.0
    return float(np.clip(np.linalg.svd(cross, compute_uv=False)[0], 0.0, 1.0))


def _inverse_root(screen: Screen, scored: Scored) -> np.ndarray:
    inverse = efficient_inverse(screen.information[scored.rows, scored.rows])
    value, vector = np.linalg.eigh(0.5 * (inverse + inverse.T))
    return vector * np.sqrt(np.maximum(value, 0.0)) @ vector.T


def tied_groups(screen: Screen) -> list[list[str]]:
    """Pairs of effects, at their best shapes, whose projected directions are nearly parallel.

    Laws are left out: among all curves of twelve coefficients one nearly parallel to anything is
    found. Whether the data tell a law from a formula its refit says.
    """
    formulas = [s for s in screen.best() if not isinstance(s.variant.effect, Law)]
    best = [(s, _inverse_root(screen, s)) for s in formulas]
    groups = []
    for i, (a, of_a) in enumerate(best):
        for b, of_b in best[i + 1 :]:
            if _cosine(screen, a, b, of_a, of_b) > TIED:
                groups.append(sorted([a.id, b.id]))
    return groups
