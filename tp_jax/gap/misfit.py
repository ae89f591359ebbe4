"""The misfit of a fit: by how much its sum of squares exceeds what noise leaves."""

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.calibration import Floor
from tp_jax.gap.free_structure import free_structure
from tp_jax.gap.held_out import floor_error
from tp_jax.gap.policy import POLICY
from tp_jax.gap.rounding import drawn_squares
from tp_jax.gap.verdict import combined


def excess(setting: PreparedCampaign, fit: Fit, least: Floor | None = None) -> float:
    """Standard errors by which the misfit exceeds the floor, its own uncertainty included.

    Args:
        setting: the campaign. fit: at its optimum. least: the floor; None: the noise alone.
    """
    parts = np.zeros(0) if least is None else least.misfit
    expected, error = noise_of_squares(setting, fit, fit.dof)
    error = np.hypot(error, np.sqrt(2.0 * np.sum(parts**2)))
    return float((fit.chi2_dof - expected - parts.sum()) / error)


def noise_of_squares(setting: PreparedCampaign, fit: Fit, dof: float) -> tuple[float, float]:
    """The mean square that noise alone leaves, in its own units, and its standard error.

    Args:
        setting: the campaign. fit: whose readings may be coarse. dof: squares in the mean.
    """
    error = np.hypot(floor_error(setting), np.sqrt(2.0 / max(dof, 1.0)))
    # Of readings in coarse steps it depends on where on a step each body comes to rest.
    drawn = drawn_squares(fit, setting, POLICY.structure.squares)
    if not drawn.size:
        # Correlated residuals have fewer degrees of freedom; the floor's error dominates anyway.
        return 1.0, float(error)
    return max(float(drawn.mean()), 1.0), float(np.hypot(error, drawn.std(ddof=1)))


def misfits(setting: PreparedCampaign, fit: Fit) -> bool:
    """True where a fit leaves more than noise by the tests that ask for no effect."""
    p = combined(1.0, free_structure(setting, fit).p, excess(setting, fit))
    return p < POLICY.structure.level
