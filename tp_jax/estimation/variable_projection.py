"""Least squares with the windows' states projected out: what `identify` fits by.

The sum of squares, minimised over the windows' states, is a function of the unknowns alone; its
Gauss-Newton matrix is what elimination leaves. A step of the unknowns takes the states along as
their linearisation says, and those it did not take to their minimum are put right one by one
(`window_states`). So a step is judged by the unknowns, and the last ones converge quadratically.

Source: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10:413; Kaufman (1975), BIT 15:49.
"""

import logging
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.coordinates import Coordinates
from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.kept_fits import taken_or_done
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import Linearisation, columns
from tp_jax.estimation.priors import GaussianPrior, prior_cost, prior_terms
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.window_states import (
    KINK,
    MAX_STATE_STEP,
    rejoin,
    settle,
    state_steps,
)

log = logging.getLogger(__name__)

#: Where kinks of the windows' states roughen the sum of squares, a promise of so many times what
#: counts as nothing may not be kept.
NOISE = 30.0
BENIGN = 0.5  # of a promise kept: then the windows' states can go on together with the unknowns
HAIR = 1e-12  # of a value: the way through its coordinate and back costs so much at the most
UNSETTLED = 0.05  # of a step's promise, shared by the windows: less is not worth an evaluation
NOTHING = 0.02  # of a mean square: a step that promises less is not taken
SETTLED = 0.01  # of a mean square: a window's state that promises less is left where it is


@taken_or_done
def fit(
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown],
    states: np.ndarray | None = None,
    *,
    bounds: dict[str, tuple[float, float]] | None = None,
    priors: Sequence[GaussianPrior] = (),
    max_iterations: int = 30,
    tolerance: float = 0.02,
    relative: float = 1e-6,
    loss: Loss = "linear",
    kinks: bool = False,
) -> Fit:
    """Fits unknowns and window states to all windows of a problem.

    Args:
        problem: recordings in windows.
        values: start, and everything that is not fitted.
        unknowns: what to fit.
        states: (w, 4) start of the window states; the smoothed readings if None.
        bounds: by name, instead of the parameters' own.
        priors: on unknowns.
        max_iterations: passes over the windows at most.
        tolerance: ends when a step promises a smaller drop of the sum of squares than this,
        relative: or than this part of it.
        loss: of a residual (see `robust`).
        kinks: whether the state of a window that lies in a kink (see `window_states`) follows the
            unknowns along it alone. Otherwise it is taken to follow them wherever its slope leads,
            which no kink keeps, and a fit may end above its neighbourhood for it.

    Returns:
        The end of the fit; its `evaluations` are passes over the windows.
    """
    unknowns = tuple(unknowns)
    space = Coordinates(unknowns, [parameter(problem, u) for u in unknowns], bounds)
    slots = columns(unknowns)
    x = np.clip(values.pick(unknowns), *space.limits.T)
    values = values.put(unknowns, x)
    at: np.ndarray = problem.initial_states(values) if states is None else states.copy()
    lin = robust(problem.linearise(values, at, slots), loss)
    passes: float = 1.0
    cost: float = lin.cost() + prior_cost(priors, unknowns, space.of(x))
    damping: float = 1e-4
    of_states: np.ndarray | None = None
    settled: bool = False
    dof = max(problem.degrees_of_freedom(len(unknowns)), 1)

    def put_right(values: Values, states: np.ndarray, lin: Linearisation, tolerance: float) -> None:
        """Moves states, and with them the linearisation, to where no window promises more."""
        nonlocal passes, of_states
        found = settle(
            problem,
            values,
            states,
            lin,
            slots,
            tolerance=tolerance,
            damping=of_states,
            loss=loss,
            kinks=kinks,
        )
        states[:], passes, of_states = found.states, passes + found.passes, found.damping

    def rejoined() -> bool:
        """True if windows fit so much better from where others ended that the fit goes on."""
        nonlocal passes, cost, joined, settled, of_states
        if joined:
            return False
        gain, more = rejoin(problem, values, at, lin, slots, tolerance=SETTLED * unit, loss=loss)
        joined, passes = True, passes + more
        cost = lin.cost() + prior_cost(priors, unknowns, space.of(x))
        if gain < enough:
            return False
        settled, of_states = True, None
        return True

    joined = False
    converged, message = False, "The iteration limit was reached."
    if not np.isfinite(cost):
        message = "The start could not be integrated."
    for iteration in range(max_iterations):
        if not np.isfinite(cost) or passes > max_iterations:
            break
        u = space.of(x)
        slope = space.slope(x)
        own, gains = state_steps(lin, np.zeros(problem.windows.n))
        kinked = gains >= KINK if kinks and settled else None
        elim = eliminated(lin, unknowns, slope, kinked=kinked)
        normal = elim.summed(*prior_terms(priors, unknowns, u))
        box = space.box(u)
        # What a wrong model leaves scatters its optimum by as much more: digits below that scatter
        # are not worth a step.
        unit = max(cost / dof, 1.0)
        enough = max(tolerance, NOTHING * unit, relative * cost)
        promise = normal.step(*box).promise
        if not settled:
            if promise < enough <= promise + gains.sum():
                put_right(values, at, lin, SETTLED * unit)
                cost = lin.cost() + prior_cost(priors, unknowns, space.of(x))
                settled = True
                continue
            own, promised = np.clip(own, -MAX_STATE_STEP, MAX_STATE_STEP), float(gains.sum())
        else:  # what is left after settling is rounding, or a kink that a step would not see
            own, promised = np.where(gains[:, None] < KINK, own, 0.0), 0.0
        if promise + promised < enough:
            if rejoined():
                continue
            converged, message = True, "The next step would gain nothing."
            break
        accepted = refused = again = False
        while not accepted:
            step = normal.step(*box, damping)
            new_x = _within(space.values(u + step.du), space.limits)
            new_values = values.put(unknowns, new_x)
            new_states = at + own + elim.following(step.du) - elim.state_step
            new_lin = robust(problem.linearise(new_values, new_states, slots), loss)
            passes += 1.0
            prior = prior_cost(priors, unknowns, space.of(new_x))
            share = (cost - new_lin.cost() - prior) / max(step.promise + promised, 1e-300)
            new_settled = False
            if new_lin.complete.all() and share < BENIGN:
                spread_out = UNSETTLED * step.promise / problem.windows.n
                put_right(new_values, new_states, new_lin, max(spread_out, SETTLED * unit))
                new_settled = True
            new_cost = new_lin.cost() + prior
            gain = (cost - new_cost) / max(step.promise + promised, 1e-300)
            log.debug(
                "projected: %d cost %.8g -> %.8g gain %.2f damping %.0e passes %.2f",
                iteration,
                cost,
                new_cost,
                gain,
                damping,
                passes,
            )
            accepted = bool(new_cost < cost)
            if accepted:
                if gain < 0.3:
                    damping *= 3.0
                elif not refused:  # what was too bold just now would be so again
                    damping = max(damping * (0.1 if gain > 0.7 else 0.5), 1e-9)
            elif np.any(own):
                # The states' own steps may be to blame: they are long where a window hardly shows
                # a direction, and what they spoil stays spoilt however short the unknowns' step.
                own, promised = np.zeros_like(own), 0.0
            elif promise < NOISE * enough or damping > 1e6:
                converged, message = True, "No direction improves the fit."
                break
            elif passes > max_iterations:
                break
            elif kinks and not settled:
                # The states' own steps may be to blame: a kink keeps none of them.
                put_right(values, at, lin, SETTLED * unit)
                cost = lin.cost() + prior_cost(priors, unknowns, space.of(x))
                settled = again = True
                break
            elif kinks and step.promise < enough:
                # Kinks refuse what the slope promises. Shorter steps promise less and less, and
                # would go on for a dozen passes after none could be worth one.
                converged, message = True, "No direction improves the fit."
                break
            else:
                refused, damping = True, 10.0 * max(damping, 1e-4)
        if again:
            continue
        if not accepted:
            if converged and rejoined():
                converged = False
                continue
            break
        small = cost - new_cost < enough and damping < 1.0
        x, values, at, lin, cost = new_x, new_values, new_states, new_lin, new_cost
        settled = new_settled
        if small:
            if rejoined():
                continue
            converged, message = True, "The last step gained nothing."
            break
    return Fit.ended(
        problem,
        values,
        at,
        lin,
        priors,
        space,
        cost=cost,
        converged=converged,
        evaluations=passes,
        message=message,
    )


def _within(x: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Values within their limits (u, 2); at one where only rounding keeps them from it."""
    hair = HAIR * np.abs(x)
    x = np.where(x <= limits[:, 0] + hair, limits[:, 0], x)
    return np.where(x >= limits[:, 1] - hair, limits[:, 1], x)
