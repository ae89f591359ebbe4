"""Whiteness without a distribution: how many runs of one sign the residuals have.

Source: Wald, Wolfowitz (1940), Annals of Mathematical Statistics 11, 147-162; the statistic is
statsmodels'.
"""

import numpy as np


def statistic(residual: np.ndarray) -> float:
    """Standardised number of runs of (n,) residuals in order; normal if white, below 0 if they
    change sign too rarely."""
    from statsmodels.sandbox.stats.runs import runstest_1samp

    if np.all(residual > 0.0) or np.all(residual <= 0.0):
        return -float(np.sqrt(residual.size))
    return float(runstest_1samp(residual, cutoff=0.0, correction=False)[0])
