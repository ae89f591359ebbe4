"""Window states found from the readings alone, for a model that has been found already.

With sharp friction such a fit ends in minima beside the right one: a rider slides in them that
should stick, and one such window of a recording held out made a right model worse than none. So the
states are found with the friction of a search first, as those of the fitted windows were, and along
kinks (see `window_states`).
"""

import functools
from collections.abc import Sequence

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.priors import GaussianPrior
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss
from tp_jax.estimation.variable_projection import fit

STEPS = 15  # of a fit of states and of few unknowns, which are well known to begin with
ENOUGH = 1e-5  # promise of a step, over the sum of squares, at which it ends


def fit_from_readings(
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown] = (),
    *,
    eps: float,
    priors: Sequence[GaussianPrior] = (),
    loss: Loss = "linear",
) -> Fit:
    """A fit of windows that no fit has seen: of their states, and of few unknowns.

    Args:
        problem: recordings in windows.
        values: all numbers; with the friction's smoothing of the fit that is wanted.
        unknowns: what to fit beside the states.
        eps: smoothing of the friction [s] to begin with, if that of `values` is sharper.
        priors: on unknowns. loss: of a residual (see `robust`).
    """
    follow = functools.partial(
        fit,
        problem,
        unknowns=unknowns,
        priors=priors,
        max_iterations=STEPS,
        relative=ENOUGH,
        loss=loss,
        kinks=True,
    )
    if values.get("eps2") <= eps:
        return follow(values)
    smooth = follow(values.replace({"eps1": eps, "eps2": eps}))
    return follow(values.put(unknowns, smooth.values.pick(unknowns)), states=smooth.states)
