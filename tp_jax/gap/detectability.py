"""What the linearisation says about the data itself: detectable sizes, what is tied."""

import numpy as np
from scipy import optimize, stats

from tp_jax.gap.screen import Scored, Screen, pseudo_inverse

POWER, FAMILY_WISE = 0.95, 0.05
TIED = 0.95  # |cos| of projected directions above which two effects are not told apart


def needed_noncentrality(q: int, tests: int) -> float:
    """Noncentrality at which a chi-square test of q amplitudes, one of many, has the power."""
    critical = stats.chi2.isf(FAMILY_WISE / tests, q)
    return float(optimize.brentq(lambda x: stats.ncx2.sf(critical, q, x) - POWER, 1e-3, 1e4))


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


def cosine(screen: Screen, a: Scored, b: Scored) -> float:
    """Largest |cos| between projected directions of two effects (canonical correlation)."""
    Va = _inverse_root(screen.information[a.rows, a.rows])
    Vb = _inverse_root(screen.information[b.rows, b.rows])
    cross = Va @ screen.information[a.rows, b.rows] @ Vb
    return (
        float(np.clip(np.linalg.svd(cross, compute_uv=False)[0], 0.0, 1.0)) if cross.size else 0.0
    )


def _inverse_root(V: np.ndarray) -> np.ndarray:
    inverse = pseudo_inverse(V)
    value, vector = np.linalg.eigh(0.5 * (inverse + inverse.T))
    return vector * np.sqrt(np.maximum(value, 0.0)) @ vector.T


def tied_groups(screen: Screen) -> list[list[str]]:
    """Pairs of effects, at their best shapes, whose projected directions are nearly parallel."""
    best = screen.best()
    groups = []
    for i, a in enumerate(best):
        for b in best[i + 1 :]:
            if cosine(screen, a, b) > TIED:
                groups.append(sorted([a.id, b.id]))
    return groups
