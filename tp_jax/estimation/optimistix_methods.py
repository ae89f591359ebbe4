"""Methods of optimistix on the windows of a problem: Levenberg-Marquardt, Dogleg, BFGS.

They minimise over the unknowns, in coordinates that have no bounds (`unbounded`) and in which one
standard error is one: none of them scales by itself. The windows' states follow linearly
(`traced_windows`) and are put right between two runs of the method, until another run gains
nothing.
"""

import functools
import math
from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float, Int

from tp_jax.estimation.bounded_step import bounded_step
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.layout import Layout, Unknown, Values
from tp_jax.estimation.least_squares import MAX_STATE_STEP, Anchor, Fit, parameter
from tp_jax.estimation.linearisation import columns, spread
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.traced_windows import Traced, evaluate, traced
from tp_jax.estimation.unbounded import Unbounded
from tp_jax.estimation.window_states import settle
from tp_jax.simulation.lanes import Tolerances

NEAR = 0.05  # standard errors: closer than that no method needs to come
RUNS = 8  # of the method, with the windows' states put right in between
EVALUATIONS = 15  # of a run
RANK = 1e-10  # relative eigenvalue of the information below which a direction is not scaled up
INSIDE = 0.05  # typical sizes off a bound: on it a coordinate without bounds has no slope

#: By the name on the command line.
SOLVERS = {
    "levenberg-marquardt": optx.LevenbergMarquardt(rtol=1e-8, atol=NEAR),
    "dogleg": optx.Dogleg(rtol=1e-8, atol=NEAR),
    "bfgs": optx.BFGS(rtol=1e-8, atol=NEAR),
}


class _Scaled(NamedTuple):
    """The windows, and the coordinates z of the method: u = inside(origin + axes @ z)."""

    windows: Traced
    origin: Float[Array, " u"]
    axes: Float[Array, "u u"]
    box: Unbounded

    def unknowns(self, z: Float[Array, " u"]) -> Float[Array, " u"]:
        return self.box.inside(self.origin + self.axes @ z)


def fit(
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown],
    states: np.ndarray | None = None,
    *,
    method: str,
    bounds: dict[str, tuple[float, float]] | None = None,
    anchors: Sequence[Anchor] = (),
    max_iterations: int = RUNS,
    tolerance: float = 0.02,
    relative: float = 1e-6,
    loss: Loss = "linear",
    blocks: int | None = None,
) -> Fit:
    """Fits unknowns and window states to all windows of a problem.

    Arguments and result are those of `variable_projection.fit`, and:

    Args:
        method: a name in `SOLVERS`.
        max_iterations: runs of the method at most.
        blocks: of windows that other horizons of the campaign have, so that one compiled program
            serves them all.
    """
    unknowns = tuple(unknowns)
    specs = [parameter(problem, u) for u in unknowns]
    given = bounds or {}
    limits = np.array([given.get(s.name, (s.lower, s.upper)) for s in specs]).reshape(-1, 2)
    to = lambda x: np.array(  # noqa: E731
        [float(s.to_coordinate(v)) for s, v in zip(specs, x, strict=True)]
    )
    floor = np.array([1e-300 if s.transform == "log" else -np.inf for s in specs])
    low, high = (to(np.maximum(end, floor)) for end in limits.T)
    # A parameter's own bounds far away are not worth a coordinate that feels them.
    wide = np.array([s.name not in given for s in specs])
    logs = np.array([s.transform == "log" for s in specs])
    box = Unbounded(
        np.where(wide & (logs | (low < 0.0)), -np.inf, low), np.where(wide, np.inf, high)
    )
    slots = columns(unknowns)
    start = to(np.clip(values.pick(unknowns), *limits.T))
    off = np.minimum(INSIDE, 0.05 * np.where(np.isfinite(box.upper), high - low, np.inf))
    u = np.clip(start, box.lower + off, box.upper - off)
    values = values.put(unknowns, _values(specs, u, limits))
    states = problem.initial_states(values) if states is None else states
    lin = robust(problem.linearise(values, states, slots), loss)
    passes = 1.0
    cost = lin.cost() + _prior(u, unknowns, anchors)
    converged, message = False, "The iteration limit was reached."
    if not np.isfinite(cost):
        message = "The start could not be integrated."
    for run in range(max_iterations):
        if not np.isfinite(cost):
            break
        slope = np.array([s.slope(v) for s, v in zip(specs, values.pick(unknowns), strict=True)])
        elim = eliminate(lin.r, lin.states_jac, spread(lin, unknowns) * slope)
        g, H = elim.g.sum(axis=0), elim.H.sum(axis=0)
        for a in anchors:
            i = unknowns.index(a.unknown)
            g[i] += (u[i] - a.centre) / a.sd**2
            H[i, i] += 1.0 / a.sd**2
        enough = max(tolerance, relative * cost)
        if run and bounded_step(g, H, low - u, high - u, 0.0).promise < enough:
            converged, message = True, "Another run of the method would gain nothing."
            break
        own = np.clip(elim.state_step, -MAX_STATE_STEP, MAX_STATE_STEP) if run == 0 else 0.0
        needed = max(blocks or 0, len(problem.blocks()))  # other noise may place them otherwise
        windows = traced(
            problem, values, states + own, elim.state_gain, unknowns, specs, anchors, needed
        )
        scaled = _scaled(windows, box, u, g, H)
        asked = problem.programs.asked([problem.layout.index[s] for s in slots])
        ids = problem.programs.cover(problem.programs.active(values.table), asked)
        found, spent = _search(
            problem.layout, problem.tolerances, ids, loss, SOLVERS[method], scaled
        )
        passes += float(spent)
        new_u = np.clip(np.asarray(found), low, high)
        if not np.isfinite(new_u).all():
            message = "The method left the region that can be integrated."
            break
        new_values = values.put(unknowns, _values(specs, new_u, limits))
        new_states = states + own + np.einsum("wxu,u->wx", elim.state_gain, new_u - u)
        new_lin = robust(problem.linearise(new_values, new_states, slots), loss)
        passes += 1.0
        if new_lin.complete.all():
            settled = settle(problem, new_values, new_states, new_lin, slots, loss=loss)
            new_states, passes = settled.states, passes + settled.passes
        new_cost = new_lin.cost() + _prior(new_u, unknowns, anchors)
        if not new_cost < cost:
            converged, message = run > 0, "Another run of the method gained nothing."
            break
        gained = cost - new_cost
        u, values, states, lin, cost = new_u, new_values, new_states, new_lin, new_cost
        if gained < enough:
            converged, message = True, "The last run of the method gained nothing."
            break
    elim = eliminate(lin.r, lin.states_jac, spread(lin, unknowns))
    x = values.pick(unknowns)
    near = 1e-3 * np.array([s.typical if s.transform == "identity" else 0.0 for s in specs])
    at_bound = (x <= limits[:, 0] + near) | (x >= limits[:, 1] - near)
    return Fit(
        problem, values, states, unknowns, cost, elim, lin, at_bound, converged,
        math.ceil(passes), message, tuple(anchors),
    )  # fmt: skip


def _scaled(
    windows: Traced, box: Unbounded, u: np.ndarray, g: np.ndarray, H: np.ndarray
) -> _Scaled:
    """Coordinates in which the information at the reference is one."""
    v = box.outside(u)
    box = Unbounded(jnp.asarray(box.lower), jnp.asarray(box.upper))
    one = jnp.ones_like(windows.at)
    slope = lambda v: jax.jvp(box.inside, (v,), (one,))[1]  # noqa: E731
    first, second = (np.asarray(d) for d in jax.jvp(slope, (jnp.asarray(v),), (one,)))
    Hv = H * np.outer(first, first) + np.diag(np.abs(g * second))
    scale = np.sqrt(np.maximum(np.diag(Hv), 1e-12 * max(np.diag(Hv).max(), 1e-300)))
    values, vectors = np.linalg.eigh(Hv / np.outer(scale, scale))
    values = np.maximum(values, RANK * values[-1])
    axes = vectors / np.sqrt(values) / scale[:, None]
    return _Scaled(windows, jnp.asarray(v), jnp.asarray(axes), box)


@eqx.filter_jit
def _search(
    layout: Layout, tolerances: Tolerances, ids: frozenset[str], loss: Loss,
    solver: optx.AbstractLeastSquaresSolver | optx.AbstractMinimiser, scaled: _Scaled,
) -> tuple[Float[Array, " u"], Int[Array, ""]]:  # fmt: skip
    """One run of a method of optimistix; coordinates u where it ended, evaluations spent."""
    both = functools.partial(_both, layout, tolerances, ids, loss)

    @jax.custom_jvp
    def residuals(z, scaled):
        return both(z, scaled)[0]

    @residuals.defjvp
    def _(primals, tangents):
        r, J = both(*primals)
        return r, J @ tangents[0]

    z0 = jnp.zeros_like(scaled.origin)
    options = {"max_steps": EVALUATIONS, "throw": False}
    if isinstance(solver, optx.AbstractMinimiser):
        half = lambda z, s: 0.5 * jnp.sum(residuals(z, s) ** 2)  # noqa: E731
        done = optx.minimise(half, solver, z0, scaled, **options)
    else:
        done = optx.least_squares(residuals, solver, z0, scaled, **options)
    return scaled.unknowns(done.value), done.stats["num_steps"]


def _both(
    layout: Layout, tolerances: Tolerances, ids: frozenset[str], loss: Loss,
    z: Float[Array, " u"], s: _Scaled,
) -> tuple[Float[Array, " r"], Float[Array, "r u"]]:  # fmt: skip
    u, slope = jax.jvp(s.box.inside, (s.origin + s.axes @ z,), (jnp.ones_like(z),))
    r, J = evaluate(layout, tolerances, ids, loss, u, s.windows)
    return r, (J * slope) @ s.axes


def _values(specs, u: np.ndarray, limits: np.ndarray) -> np.ndarray:
    x = np.array([float(s.from_coordinate(c)) for s, c in zip(specs, u, strict=True)])
    return np.clip(x, *limits.T)


def _prior(u: np.ndarray, unknowns: tuple[Unknown, ...], anchors: Sequence[Anchor]) -> float:
    return sum(((u[unknowns.index(a.unknown)] - a.centre) / a.sd) ** 2 for a in anchors)
