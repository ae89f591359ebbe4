"""Heteroscedasticity: do the residuals spread more at some times, angles, velocities?

Source: Breusch, Pagan (1979), Econometrica 47, 1287-1294, in Koenker's form, which does not assume
them normal; the statistic is statsmodels'.
"""

import numpy as np

DEGREES = 2


def statistic(residual: np.ndarray, against: np.ndarray) -> float:
    """LM of (n,) residuals against a parabola in (n,) values; chi-square with 2 degrees of freedom
    if they spread evenly. 0 where the values do not vary."""
    from statsmodels.stats.diagnostic import het_breuschpagan

    spread = against.std()
    if not spread > 0.0:
        return 0.0
    x = (against - against.mean()) / spread
    columns = np.stack([np.ones_like(x), x, x**2], axis=1)
    if np.linalg.matrix_rank(columns) < DEGREES + 1:
        return 0.0
    return float(het_breuschpagan(residual, columns)[0])
