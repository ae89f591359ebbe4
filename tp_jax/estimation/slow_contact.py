"""A contact whose friction rises faster than any speed that is met, sought again where it does not.

A contact's exponential that has died out at nine tenths of all speeds has no derivative that leads
back to where it had not: what is left of the gap passes for a contact that weakens with speed.
"""

import logging
from collections.abc import Callable
from typing import Any

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.prepared_campaign import PreparedCampaign

log = logging.getLogger(__name__)

DIED = 3.0
"""T0 times a slip speed from which the contact's exponential has died out there, to a twentieth."""


def with_slow_contact(
    setting: PreparedCampaign, found: Fit, method: Callable[..., Fit], how: dict[str, Any]
) -> Fit:
    """The better of two fits: as found, and sought where its contact rises at speeds that are met.

    Only where that found rises at speeds too small to be met.

    Args:
        setting: the campaign. found: a fit of all its windows.
        method: see `variable_projection.fit`. how: its options, with which it was found.
    """
    if Unknown("T0") not in found.unknowns or not np.isfinite(found.cost):
        return found
    speed = np.concatenate([np.abs(setting.prepared[i].path[:, 3]) for i in setting.fitted])
    if not (found.values.get("Tst") and speed.any()):  # then T0 is of no matter
        return found
    speed = speed[speed > 0.1 * speed.max()]  # of a rider that sticks it is noise
    if found.values.get("T0") * np.quantile(speed, 0.1) < DIED:
        return found
    start = found.values.replace({"T0": 1.0 / float(np.median(speed))})
    # held there first, or the others, which are those of another contact, would drive it back
    others = [u for u in found.unknowns if u.name != "T0"]
    priors = [a for a in how["priors"] if a.unknown.name != "T0"]
    held = method(found.problem, start, others, found.states, **{**how, "priors": priors})
    other = method(found.problem, held.values, found.unknowns, held.states, **how)
    log.info(
        "T0 %.3g instead of %.3g: chi2/dof %.5g, was %.5g",
        other.values.get("T0"),
        found.values.get("T0"),
        other.chi2_dof,
        found.chi2_dof,
    )
    return min(found, other, key=lambda one: one.cost)
