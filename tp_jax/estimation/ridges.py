"""Intervals over a ridge: of a number that the data do not tell, and of what makes up for it.

In most parameters the equations are linear, in T0 they are not. Where the data do not tell it, or
it ends at a bound, a parabola at the best point is no measure: it holds T0 where it ended, and
calls its partners sure. So it is held at values over its whole range, all others are fitted again,
and every value that fits as well within chance counts: all intervals cover what the others were.

Source: Venzon and Moolgavkar (1988), Appl. Stat. 37:87 (profile likelihood).
"""

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.intervals import intervals
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.robust import Loss
from tp_jax.estimation.variable_projection import fit as fit_projected

NONLINEAR = ("T0",)  # numbers in which the equations are not linear
POINTS = 6  # values that a doubtful number is held at
SMALLEST = 1e-3  # of the value: so far down a range that begins at zero is looked at
CHANCE = 0.05  # that a value which is left out was the true one
MUCH = 1.5  # times its width: an interval that grew so much is on the ridge
NORMAL = 1.96  # standard errors of half a 95 % interval


def intervals_over_ridges(
    fit: Fit, setting: PreparedCampaign, loss: Loss = "linear"
) -> dict[str, dict]:
    """Computes `intervals`, but over the ridges of nonlinear numbers that are not identified.

    An entry whose interval grew has `ridge`, the name of the number that was held.
    """
    found = intervals(fit, setting)
    for name in NONLINEAR:
        if name in found and not found[name]["identifiable"]:
            _join(found, fit, setting, name, loss)
    return found


def _join(
    found: dict[str, dict], fit: Fit, setting: PreparedCampaign, name: str, loss: Loss
) -> None:
    """Takes the fits with one number held into the intervals."""
    which = next(u for u in fit.unknowns if u.name == name and u.recording is None)
    spec = parameter(fit.problem, which)
    low, high = setting.bounds.get(name, (spec.lower, spec.upper))
    own = fit.values.get(name)
    ends = [float(spec.to_coordinate(max(x, SMALLEST * own))) for x in (low, high)]
    others = tuple(u for u in fit.unknowns if u != which)
    priors = [a for a in fit.priors if a.unknown != which]
    held = [own, *(float(spec.from_coordinate(c)) for c in np.linspace(ends[0], ends[1], POINTS))]
    fits = [
        fit_projected(
            fit.problem,
            fit.values.put((which,), np.array([x])),
            others,
            fit.states,
            bounds=setting.bounds,
            priors=priors,
            loss=loss,
            kinks=True,
        )
        for x in held
    ]
    # The first fit is that of the value which is there already. Where windows' states lie in kinks
    # of the friction it ends elsewhere than before; so much must not tell two values apart either.
    lowest, rough = min(fit.cost, *(f.cost for f in fits)), abs(fit.cost - fits[0].cost)
    enough = float(tails.chi_square_level(CHANCE, 1.0)) * max(fit.chi2_dof, 1.0) + rough
    as_good = [f.cost - lowest <= enough for f in fits]
    good = [x for x, g in zip(held, as_good, strict=True) if g]
    if max(good, default=own) <= min(good, default=own) or not np.isfinite(rough):
        return
    below, above = found[name]["ci95"]
    found[name].update(ci95=[min(below, *good), max(above or own, *good)], ridge=name)
    for other, good_too in zip(fits, as_good, strict=True):
        if not good_too:
            continue
        for partner, entry in intervals(other, setting).items():
            ends = entry["ci95"]
            upper = entry["value"] if ends[1] is None else ends[1]
            _widen(found[partner], ends[0], upper, name)


def _widen(entry: dict, low: float, high: float, ridge: str) -> None:
    """Makes an interval cover another; what becomes much wider is on the ridge."""
    before = entry["ci95"]
    upper = entry["value"] if before[1] is None else before[1]
    new = [min(before[0], low), max(upper, high)]
    width = new[1] - new[0]
    entry["ci95"] = new
    if entry["standard_error"] is None or width <= MUCH * (upper - before[0]):
        return
    entry.update(standard_error=width / (2.0 * NORMAL), ridge=ridge)
    if width > abs(entry["value"]):  # half of it, each way, of a ridge that is flat
        entry["identifiable"] = False
