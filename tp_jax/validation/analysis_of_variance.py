"""Structure: is the mean of the residuals the same at all times, angles, velocities?

One-way analysis of variance over cells of equal count; the statistic is SciPy's.
"""

import numpy as np
from scipy import stats

CELLS = 12


def cells(n: int) -> int:
    """Cells into which n residuals are sorted."""
    return max(2, min(CELLS, n // 10))


def statistic(residual: np.ndarray, against: np.ndarray) -> float:
    """F of (n,) residuals over cells of (n,) values, times its first degrees of freedom: about
    chi-square with `cells(n) - 1` of them if the mean is the same. 0 where they do not vary."""
    if not np.ptp(against) > 0.0:
        return 0.0
    order = np.argsort(against, kind="stable")
    groups = np.array_split(residual[order], cells(residual.size))
    return float(stats.f_oneway(*groups).statistic) * (len(groups) - 1)
