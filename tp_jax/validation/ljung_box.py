"""Whiteness: autocorrelations of the residuals, all lags up to some together.

Source: Ljung, Box (1978), Biometrika 65, 297-303; the statistic is statsmodels'.
"""

import numpy as np

LAGS = 20


def lags(n: int) -> int:
    """Lags looked at in n residuals."""
    return max(1, min(LAGS, n // 5))


def statistic(residual: np.ndarray) -> float:
    """Q of (n,) residuals in order; chi-square with `lags(n)` degrees of freedom if white."""
    from statsmodels.stats.diagnostic import acorr_ljungbox

    table = acorr_ljungbox(residual - residual.mean(), lags=[lags(residual.size)])
    return float(table["lb_stat"].iloc[0])
