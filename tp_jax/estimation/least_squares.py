"""Gauss-Newton with Levenberg-Marquardt damping over unknowns and window states together."""

import dataclasses
import logging
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit, GaussianPrior, parameter
from tp_jax.estimation.kept_fits import taken_or_done
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import columns, spread
from tp_jax.estimation.problem import Problem
from tp_jax.model.parameters import Parameter

log = logging.getLogger(__name__)

MAX_STATE_STEP = np.array([0.05, 0.05, 2.0, 2.0])  # rad, rad/s


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
    relative: float = 1e-7,
) -> Fit:
    """Fits unknowns and window states to all windows of a problem.

    Args:
        problem: recordings in windows.
        values: start, and everything that is not fitted.
        unknowns: what to fit.
        states: (w, 4) start of the window states; the smoothed readings if None.
        bounds: by name, instead of the parameters' own.
        priors: on unknowns.
        max_iterations: linearisations at most.
        tolerance: ends when a step promises a smaller drop of the sum of squares than this,
        relative: or than this part of it.
    """
    unknowns = tuple(unknowns)
    specs = [parameter(problem, u) for u in unknowns]
    limits = np.array([(bounds or {}).get(s.name, (s.lower, s.upper)) for s in specs])
    limits = limits.reshape(-1, 2)
    slots = columns(unknowns)
    x = values.pick(unknowns)
    x = np.clip(x, limits[:, 0], limits[:, 1])
    damping, tried = 1e-3, 0
    values = values.put(unknowns, x)
    states = problem.initial_states(values) if states is None else states
    lin = problem.linearise(values, states, slots)
    cost = lin.cost() + _anchor_cost(values, priors, problem)
    converged, message = False, "The iteration limit was reached."
    if not np.isfinite(cost):
        message = "The start could not be integrated."
    for tried in range(1, max_iterations + 1):
        if not np.isfinite(cost):
            break
        step = _step(lin, unknowns, specs, x, limits, priors, damping)
        enough = max(tolerance, relative * cost)
        if step.promise < enough:
            converged, message = True, "The next step would gain nothing."
            break
        new_x, new_states = step.x, states + step.states
        new_values = values.put(unknowns, new_x)
        new_lin = problem.linearise(new_values, new_states, slots)
        new_cost = new_lin.cost() + _anchor_cost(new_values, priors, problem)
        gain = (cost - new_cost) / step.promise
        log.debug(
            "fit: %d cost %.6g -> %.6g gain %.2f damping %.1e", tried, cost, new_cost, gain, damping
        )
        if new_cost < cost:
            x, states, values, lin = new_x, new_states, new_values, new_lin
            small = cost - new_cost < enough and damping < 1.0
            cost = new_cost
            damping = max(damping * (0.1 if gain > 0.7 else 0.5 if gain > 0.3 else 3.0), 1e-9)
            if small:
                converged, message = True, "The last step gained nothing."
                break
        else:
            damping = max(damping, 1e-4) * 8.0
            if damping > 1e8:
                converged, message = True, "No direction improves the fit."
                break
    elim = eliminate(lin.r, lin.states_jac, spread(lin, unknowns))
    at_bound = (x <= limits[:, 0]) | (x >= limits[:, 1])
    return Fit(
        problem,
        values,
        states,
        unknowns,
        cost,
        elim,
        lin,
        at_bound,
        converged,
        tried,
        message,
        tuple(priors),
    )


@dataclasses.dataclass(frozen=True)
class _Step:
    x: np.ndarray
    states: np.ndarray
    promise: float


def _anchor_residual(a: GaussianPrior, values: Values, problem: Problem) -> float:
    spec = parameter(problem, a.unknown)
    u = spec.to_coordinate(values.get(a.unknown.name, a.unknown.recording))
    return float((u - a.mean) / a.sd)


def _anchor_cost(values: Values, priors: Sequence[GaussianPrior], problem: Problem) -> float:
    return sum(_anchor_residual(a, values, problem) ** 2 for a in priors)


def _step(lin, unknowns, specs, x, limits, priors, damping) -> _Step:
    """Damped Gauss-Newton step; unknowns at a bound that push outward stay (active set)."""
    slope = np.array([s.slope(v) for s, v in zip(specs, x, strict=True)])
    jac = spread(lin, unknowns) * slope
    elim = eliminate(lin.r, lin.states_jac, jac, damping)
    g, H = elim.g.sum(axis=0), elim.H.sum(axis=0)
    for a in priors:
        i = unknowns.index(a.unknown)
        spec = specs[i]
        g[i] += (float(spec.to_coordinate(x[i])) - a.mean) / a.sd**2
        H[i, i] += 1.0 / a.sd**2
    lo = np.array([_coordinate(s, v) for s, v in zip(specs, limits[:, 0], strict=True)])
    hi = np.array([_coordinate(s, v) for s, v in zip(specs, limits[:, 1], strict=True)])
    u = np.array([float(s.to_coordinate(v)) for s, v in zip(specs, x, strict=True)])
    scale = np.diag(H).copy()
    scale = np.maximum(scale, 1e-12 * max(scale.max(initial=0.0), 1e-300))
    du = np.zeros_like(u)
    free = np.ones(u.size, dtype=bool)
    for _ in range(u.size + 1):  # primal active set: a bound that is hit becomes a constraint
        du[:] = np.where(free, 0.0, np.clip(du, lo - u, hi - u))
        if free.any():
            A = H[np.ix_(free, free)] + damping * np.diag(scale[free])
            rhs = -(g[free] + H[np.ix_(free, ~free)] @ du[~free])
            du[free] = np.linalg.lstsq(A, rhs, rcond=1e-14)[0]
        logs = np.array([s.transform == "log" for s in specs])
        du = np.where(logs, np.clip(du, -1.0, 1.0), du)
        out = free & ((u + du < lo) | (u + du > hi))
        if not out.any():
            break
        du = np.clip(du, lo - u, hi - u)
        free &= ~out
    du = np.clip(du, lo - u, hi - u)
    # The states' own step is limited, not how they follow the unknowns: a zero moves them all.
    states = np.clip(elim.state_step, -MAX_STATE_STEP, MAX_STATE_STEP)
    states = states + np.einsum("wxu,u->wx", elim.state_gain, du)
    promise = -float(2.0 * g @ du + du @ H @ du)
    promise += float(((lin.r**2).sum(axis=1) - elim.cost).sum())
    new = np.array([float(s.from_coordinate(v)) for s, v in zip(specs, u + du, strict=True)])
    new = np.clip(new, limits[:, 0], limits[:, 1])
    return _Step(new, states, promise)


def _coordinate(spec: Parameter, value: float) -> float:
    if spec.transform == "log":
        return float(np.log(max(value, 1e-300)))
    return float(spec.to_coordinate(value))
