"""The last step of a fit: friction so sharp that a noise of a milliradian hides its smoothing.

At the smoothing with which a fit is searched for the rider's angle is off by a tenth of a
milliradian, less than that noise and yet, over ten thousand samples, up to six standard errors of
Ts1, Tst and T0. The error falls about as eps^(-2/3), so better sensors may still see it.
A search with sharper friction ends in kinks of the sum of squares; from where a search has ended
the way is short. It is gone in two steps: in one, the fit of a simulated rig ended 93 above its
least sum of squares, and what that left passed for structure.

Errors of the integration move a sum of squares of thirty thousand by up to one. That does not hurt
a search, but it does a likelihood profile, which ends where the sum has risen by four. So the last
step is integrated more finely too.
"""

import logging

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.schedule import FINE, FINELY, PATIENCE, ROUGH, halfway
from tp_jax.estimation.variable_projection import fit

log = logging.getLogger(__name__)

WORSE = 10.0  # of the sum of squares, in the misfit's unit: more is a kink and not the friction


def fit_with_sharp_friction(
    setting: PreparedCampaign,
    before: Fit,
    *,
    bounds: dict[str, tuple[float, float]] | None = None,
    max_iterations: int = PATIENCE,
) -> Fit:
    """A fit with the friction's smoothing at `PreparedCampaign.sharpest`.

    Args:
        setting: the campaign.
        before: fit with the search's smoothing; what was fitted is fitted again.
        bounds: those of the setting if None.
        max_iterations: see `variable_projection.fit`.

    Returns:
        The new fit; `before` where that has none sharper to go to, or the new one ended in a kink.
    """
    eps = setting.sharpest
    if not eps > before.values.get("eps2") or not np.isfinite(before.cost):
        return before
    problem, after = before.problem.at(FINELY), before
    for each, enough in ((halfway(before.values.get("eps2"), eps), ROUGH), (eps, FINE)):
        after = fit(
            problem,
            after.values.replace({"eps1": each, "eps2": each}),
            before.unknowns,
            after.states,
            bounds=setting.bounds if bounds is None else bounds,
            priors=before.priors,
            max_iterations=max_iterations,
            relative=enough,
            kinks=True,
        )
    log.info("eps %.3g: chi2/dof %.5g, was %.5g", eps, after.chi2_dof, before.chi2_dof)
    return after if after.cost < before.cost + WORSE * max(before.chi2_dof, 1.0) else before
