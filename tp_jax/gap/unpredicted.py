"""Test of the prediction of held-out recordings, within the errors of the fitted numbers.

A model may leave nothing but noise in the recordings that it is fitted to and still be wrong: of
three runs two may be of one amplitude, and a spring that hardens passes for a stiffer one until a
run goes further. The tests of structure do not see that, since they look at what was fitted.

So the numbers are asked to give way to the held-out recordings as far as the fitted ones let them.
The sum of squares that this adds is that of noise where the model is right (a test of forecasts;
Chow, 1960, Econometrica 28, 591-605). Where fitted recordings say nothing of a number, held-out
ones may take it to where they need it: that they are predicted badly is then no gap.
"""

import numpy as np

from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.linearisation import columns as slots_of
from tp_jax.estimation.linearisation import spread
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import calibration
from tp_jax.gap.choice import Choice
from tp_jax.gap.held_out import HeldOut, common_horizon, evaluate
from tp_jax.gap.misfit import noise_of_squares
from tp_jax.gap.policy import POLICY
from tp_jax.gap.visited import in_its_place


def better_held_out(setting: PreparedCampaign, choice: Choice) -> int | None:
    """The recording to hold out instead of one that shows what the fitted ones do not.

    Where nothing is found in the fitted recordings and the held-out one is not predicted, it has
    to be fitted, or no cause could be. This reads the prediction of the recording that is held out,
    which so becomes a fitted one; that of its successor is not read. None: that is not so, or there
    is no other to hold out.

    Args:
        setting: the campaign. choice: of causes.
    """
    if choice.final.ids or len(setting.held_out) != 1 or len(setting.fitted) < 2:
        return None
    fit = choice.baseline
    horizon = common_horizon(setting, fit.problem.windows.horizon)
    held = evaluate(setting, fit.values, horizon)
    if not held.complete or unpredicted(setting, fit, held) <= POLICY.structure.unpredicted:
        return None
    return next(iter(in_its_place(setting)), None)


def unpredicted(setting: PreparedCampaign, fit: Fit, held: HeldOut) -> float:
    """Standard errors by which held-out windows exceed noise and the errors of the numbers.

    Numbers at a bound may move too, on either side: that they cannot is no reason for a gap here.

    Args:
        setting: the campaign.
        fit: of the fitted recordings, at its optimum.
        held: held-out windows under it.
    """
    there, unknowns = held.setting or setting, fit.unknowns
    g, H, cost = _quadratic(setting, fit, spread(fit.linearisation, unknowns))
    u, known = len(unknowns), fit.normal()
    g[:u] += known.g - fit.normal(()).g  # the priors pull where the data pull against them
    H[:u, :u] += np.diag(known.prior)
    H[u:, u:] += np.eye(len(H) - u)  # shapes of a calibration's error have a deviation of one
    lin = held.fit.problem.linearise(held.fit.values, held.fit.states, slots_of(unknowns))
    g_held, H_held, cost_held = _quadratic(there, held.fit, spread(lin, unknowns))
    before = cost - g @ scaled_inverse(H) @ g
    both = cost + cost_held - (g + g_held) @ scaled_inverse(H + H_held) @ (g + g_held)
    n = float(held.fit.problem.degrees_of_freedom(0))
    expected, error = noise_of_squares(setting, fit, n)
    return float(((both - before) / max(n, 1.0) - expected) / error)


def _quadratic(
    setting: PreparedCampaign, fit: Fit, jac: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Gradient, information and least sum of squares of a fit's windows, states projected out.

    By the unknowns and the shapes of the calibration's error; without priors.
    """
    lin = fit.linearisation
    every = np.concatenate([jac, calibration.columns(setting, fit)], axis=2)
    out = eliminate(lin.r, lin.states_jac, every)
    return out.g.sum(axis=0), out.H.sum(axis=0), float(out.cost.sum())
