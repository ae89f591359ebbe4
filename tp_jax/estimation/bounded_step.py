"""A damped Gauss-Newton step that stays within bounds."""

import dataclasses

import numpy as np
from scipy.optimize import lsq_linear

LONGEST_LOG = 1.0  # a factor of e: further than that no linearisation of a logarithm reaches


@dataclasses.dataclass(frozen=True)
class Step:
    """du: (u,) in estimation coordinates; promise: the drop of the sum of squares it promises."""

    du: np.ndarray
    promise: float


def bounded_step(
    g: np.ndarray, H: np.ndarray, lower: np.ndarray, upper: np.ndarray, damping: float
) -> Step:
    """Minimises 2 g'du + du'(H + damping diag H) du with lower <= du <= upper.

    The bounded least squares are exact (BVLS: Stark and Parker 1995, Comput. Stat. 10:129): what
    a bound stops, the others make up for.

    Args:
        g: (u,) half the gradient of the sum of squares. H: (u, u) its Gauss-Newton matrix.
        lower, upper: (u,) bounds of the step, 0 in between.
        damping: relative, of Levenberg and Marquardt.
    """
    if not g.size:
        return Step(np.zeros(0), 0.0)
    scale = np.sqrt(np.maximum(np.diag(H), 1e-12 * max(np.diag(H).max(initial=0.0), 1e-300)))
    Hs = H / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(Hs + damping * np.eye(len(g)))
    # what the data do not tell must not make the step anything at all
    values = np.maximum(values, 1e-13 * max(values[-1], 1e-300))
    root = np.sqrt(values)[:, None] * vectors.T
    target = -(vectors.T @ (g / scale)) / np.sqrt(values)
    narrow = upper - lower < 1e-300
    low = np.where(narrow, -1e-300, lower) * scale
    high = np.where(narrow, 1e-300, upper) * scale
    du = lsq_linear(root, target, (low, high), method="bvls").x / scale
    du = np.clip(du, lower, upper)
    return Step(du, -float(2.0 * g @ du + du @ H @ du))
