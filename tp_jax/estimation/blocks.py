"""Blocks of windows, over which scores are summed before their scatter is taken.

Neighbouring windows are correlated by what the model lacks; blocks of two periods or more nearly
are not.
"""

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign

BLOCK = 2.0  # periods of the motion, so that a rig's time scale changes nothing


def blocks_of(fit: Fit, setting: PreparedCampaign) -> np.ndarray:
    """Block of each window (w,): consecutive windows of a recording, two periods or more."""
    w = fit.problem.windows
    out = np.zeros(w.n, dtype=int)
    block, spent, last = -1, np.inf, None
    for i in range(w.n):
        t = setting.prepared[w.recording[i]].t
        length = t[w.first[i] + w.count[i] - 1] - t[w.first[i]]
        if w.recording[i] != last or spent >= 0.95 * BLOCK * setting.period:
            block, spent, last = block + 1, 0.0, w.recording[i]
        out[i] = block
        spent += length
    return out
