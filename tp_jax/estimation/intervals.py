"""Intervals of fitted numbers: covariance from the scatter of blocks, t quantiles."""

import numpy as np
from scipy import stats

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.least_squares import Fit, parameter


def covariance(fit: Fit, setting: Setting) -> tuple[np.ndarray, int]:
    """Sandwich covariance (u, u) of the unknowns, and the number of blocks.

    Unknowns at a bound get none (zero rows). Never below the covariance that the noise alone
    would give.
    """
    free = ~fit.at_bound
    H = fit.information()[np.ix_(free, free)]
    scale = np.sqrt(np.maximum(np.diag(H), 1e-300))
    inverse = np.linalg.pinv(H / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    inverse = inverse / np.outer(scale, scale)
    block = blocks_of(fit, setting)
    n = int(block.max()) + 1
    g = np.zeros((n, int(free.sum())))
    np.add.at(g, block, fit.eliminated.g[:, free])
    g = g - g.mean(axis=0)
    robust = inverse @ (g.T @ g * n / max(n - 1, 1)) @ inverse
    ratio = np.sqrt(np.maximum(np.diag(inverse) / np.maximum(np.diag(robust), 1e-300), 1.0))
    robust = robust * np.outer(ratio, ratio)
    out = np.zeros((free.size, free.size))
    out[np.ix_(free, free)] = robust
    return out, n


def intervals(fit: Fit, setting: Setting) -> dict[str, dict]:
    """Each campaign-wide unknown: value, unit, ci95, whether the data identify it.

    An unknown counts as identified where it is off its bounds and its standard error is below
    half of its value (or, for what may be zero, of its typical size).
    """
    cov, n = covariance(fit, setting)
    t = float(stats.t.isf(0.025, max(n - len(fit.unknowns), 2)))
    anchored = {a.unknown: a for a in fit.anchors}
    out = {}
    for i, u in enumerate(fit.unknowns):
        if u.recording is not None:
            continue
        spec = parameter(fit.problem, u)
        value = fit.values.get(u.name)
        sd = float(np.sqrt(max(cov[i, i], 0.0)))
        if fit.at_bound[i]:
            out[u.name] = {
                "value": value, "unit": spec.unit, "ci95": [value, None], "identifiable": False,
                "standard_error": None,
            }  # fmt: skip
            continue
        if spec.transform == "log":
            half = min(t * sd / max(value, 1e-300), 50.0)
            low, high = value * np.exp(-half), value * np.exp(half)
        else:
            low, high = value - t * sd, value + t * sd
        low, high = max(low, spec.lower), min(high, spec.upper)
        size = abs(value) if u.name not in ("phase", "zero1", "level") else spec.typical
        prior = anchored.get(u)
        held = prior is not None and sd > 0.5 * prior.sd * spec.slope(value)
        out[u.name] = {
            "value": value, "unit": spec.unit, "ci95": [float(low), float(high)],
            "identifiable": bool(sd < 0.5 * size and not held), "standard_error": sd,
        }  # fmt: skip
    return out
