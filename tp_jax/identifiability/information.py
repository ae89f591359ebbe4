"""Information of a fit: its matrix, correlations, combinations that stay unknown.

The information is that of the linearised residuals in windows, their states eliminated
(`tp_jax.estimation.elimination`); its inverse bounds the covariance of any unbiased estimate
(Cramér-Rao).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.normal_equations import covariance_of, projected
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.identifiability.null_directions import Direction
from tp_jax.model.parameters import NUISANCES

UNKNOWN = np.log(2.0)
"""A combination known no better than to this (a factor of two, one standard deviation) counts as
unknown."""

FEW = 0.1
"""Coefficients below this part of the largest are left out of a direction that is only weak."""

_NUISANCES = frozenset(p.name for p in NUISANCES)


class Information(NamedTuple):
    """Information of a fit.

    names: (u,) unknowns, nuisances included; matrix: (u, u) in relative changes, that of a
    parameter that is zero, or of a nuisance, in units of its typical size; scale: (u,) those
    units [SI]; correlation: (u, u) of the estimates; sd: (u,) standard deviations [SI], the
    misfit beyond the noise included; directions: combinations of parameters, nuisances
    optimised, that these data leave unknown.
    """

    names: tuple[str, ...]
    matrix: Float[np.ndarray, "u u"]
    scale: Float[np.ndarray, " u"]
    correlation: Float[np.ndarray, "u u"]
    sd: Float[np.ndarray, " u"]
    directions: tuple[Direction, ...]


def information(fit: Fit, setting: PreparedCampaign) -> Information:
    """Information of a fit; what its campaign states beforehand counts, a mere guard does not.

    Args:
        fit: of the baseline's unknowns.
        setting: its campaign.
    """
    names = tuple(u.name for u in fit.unknowns)
    scale = np.array([_scale(fit, i) for i in range(len(names))])
    # The prior on T0 only keeps steps finite: what it alone decides is not known.
    stated = [a for a in fit.priors if a.unknown.name in setting.prior_values]
    normal = fit.normal(stated)
    H = normal.H / max(fit.chi2_dof, 1.0) + np.diag(normal.prior)
    matrix = H * np.outer(scale, scale)
    covariance = covariance_of(matrix)
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    safe = np.where(sd > 0.0, sd, 1.0)
    correlation = np.clip(covariance / np.outer(safe, safe), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    return Information(names, matrix, scale, correlation, sd * scale, _weak(matrix, names, UNKNOWN))


def _scale(fit: Fit, i: int) -> float:
    u = fit.unknowns[i]
    spec = parameter(fit.problem, u)
    value = abs(fit.values.get(u.name, u.recording))
    if spec.transform == "log":
        return value
    small = value < 1e-3 * spec.typical
    return spec.typical if small or u.name in _NUISANCES else value


def _weak(matrix: np.ndarray, names: tuple[str, ...], unknown: float) -> tuple[Direction, ...]:
    """Eigenvectors of what is left for the parameters when the nuisances are optimised."""
    p = [i for i, n in enumerate(names) if n not in _NUISANCES]
    q = [i for i, n in enumerate(names) if n in _NUISANCES]
    value, vector = np.linalg.eigh(projected(matrix, p, q))
    out = []
    for size, row in zip(value, vector.T, strict=True):
        largest = float(row[np.argmax(np.abs(row))])
        row = row / largest
        sd = 1.0 / np.sqrt(max(float(size), 1e-300)) * abs(largest)
        if sd < unknown:
            continue
        kept = {names[i]: float(x) for i, x in zip(p, row, strict=True) if abs(x) >= FEW}
        out.append(Direction(kept, "practical", sd))
    return tuple(out)
