"""Intervals of fitted numbers: from the noise, or from the scatter of blocks where that is more."""

import dataclasses

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.drive_errors import drives_out
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.prepared_campaign import PreparedCampaign

NOISE = 1.1  # chi2/dof that noise may have, whose level is an estimate
CHANCE = 0.01  # that blocks of noise scatter so much that it counts as more


def covariance(fit: Fit, setting: PreparedCampaign) -> tuple[np.ndarray, np.ndarray]:
    """Covariance (u, u) of the unknowns, and the degrees of freedom of each variance (u,).

    It is that which the noise gives, that of measured drives included (and all of a misfit beyond
    it), but for unknowns in whose direction the blocks scatter more than chance would have it:
    those have the sandwich's variance, known with the blocks' degrees of freedom. The larger of the
    two always would be too large, as the sandwich's is an estimate from few blocks. Unknowns at a
    bound get none (zero rows).
    """
    free = ~fit.at_bound
    told = drives_out(setting, fit)
    inverse = dataclasses.replace(fit.normal(), H=told.H).part(free).covariance()
    block = blocks_of(fit, setting)
    n = int(block.max()) + 1
    g, H = told.sums(block)
    g = g[:, free] - g[:, free].mean(axis=0)
    robust = np.diag(inverse @ (g.T @ g * n / max(n - 1, 1)) @ inverse)
    part = np.einsum("ui,bij,ju->bu", inverse, H[:, free][:, :, free], inverse, optimize=True)
    telling = part.sum(axis=0) ** 2 / np.maximum((part**2).sum(axis=0), 1e-300)
    misfit = fit.chi2_dof if fit.chi2_dof > NOISE else 1.0
    excess = robust / np.maximum(misfit * np.diag(inverse), 1e-300)
    beyond = excess > tails.chi_square_level(CHANCE, telling) / np.maximum(telling, 1e-300)
    ratio = np.sqrt(misfit * np.where(beyond, np.maximum(excess, 1.0), 1.0))
    out, dof = np.zeros((free.size, free.size)), np.full(free.size, np.inf)
    out[np.ix_(free, free)] = inverse * np.outer(ratio, ratio)
    dof[free] = np.where(beyond, max(n - len(fit.unknowns), 2), np.inf)
    return out, dof


def correlations(fit: Fit, setting: PreparedCampaign) -> dict[str, list]:
    """Correlations of the errors of the campaign-wide unknowns that are off their bounds.

    Returns:
        names (q,) and matrix (q, q); see `covariance`.
    """
    cov, _ = covariance(fit, setting)
    mine = [i for i, u in enumerate(fit.unknowns) if u.recording is None and cov[i, i] > 0.0]
    sd = np.sqrt(np.diag(cov)[mine])
    matrix = np.clip(cov[np.ix_(mine, mine)] / np.outer(sd, sd), -1.0, 1.0)
    return {"names": [fit.unknowns[i].name for i in mine], "matrix": matrix.tolist()}


def intervals(fit: Fit, setting: PreparedCampaign) -> dict[str, dict]:
    """Each campaign-wide unknown: value, unit, ci95, whether the data identify it.

    An unknown counts as identified where it is off its bounds and its standard error is below
    half of its value (or, for what may be zero, of its typical size).
    """
    cov, dof = covariance(fit, setting)
    with_prior = {a.unknown: a for a in fit.priors}
    out = {}
    for i, u in enumerate(fit.unknowns):
        if u.recording is not None:
            continue
        spec = parameter(fit.problem, u)
        value = fit.values.get(u.name)
        sd = float(np.sqrt(max(cov[i, i], 0.0)))
        t = float(tails.student_level(0.025, dof[i]))
        if fit.at_bound[i]:
            out[u.name] = {
                "value": value,
                "unit": spec.unit,
                "ci95": [value, None],
                "identifiable": False,
                "standard_error": None,
            }
            continue
        if spec.transform == "log":
            half = min(t * sd / max(value, 1e-300), 50.0)
            low, high = value * np.exp(-half), value * np.exp(half)
        else:
            low, high = value - t * sd, value + t * sd
        # a shape constant may lie beyond its grid, and a bound that was given beyond the usual one
        low = max(low, spec.lower) if value >= spec.lower else low
        high = min(high, spec.upper) if value <= spec.upper else high
        size = abs(value) if u.name not in ("phase", "zero1", "level", "preload") else spec.typical
        prior = with_prior.get(u)
        held = prior is not None and sd > 0.5 * prior.sd * spec.slope(value)
        out[u.name] = {
            "value": value,
            "unit": spec.unit,
            "ci95": [float(low), float(high)],
            "identifiable": bool(sd < 0.5 * size and not held),
            "standard_error": sd,
        }
    return out
