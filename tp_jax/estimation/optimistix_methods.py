"""Methods of optimistix on the windows of a problem: Levenberg-Marquardt, Dogleg, BFGS and others.

All minimise one function, `window_residuals`, in coordinates in which one standard error is one:
none of them scales by itself. None knows bounds either: beyond one the function is constant, and an
unknown that the best step takes to a bound is put there for a run, and let go if it wants back. The
windows' states are put where they fit best inside the function, from where the run's reference and
its slopes take them; between two runs they are settled anew.
"""

import logging
import math
from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float, Int, PyTree, Scalar

from tp_jax.estimation import variable_projection
from tp_jax.estimation.coordinates import Coordinates
from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import columns
from tp_jax.estimation.normal_equations import NormalEquations
from tp_jax.estimation.priors import GaussianPrior, prior_cost, prior_terms
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.projected_gauss_newton import VariableProjection
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.variable_projection import NOTHING, SETTLED
from tp_jax.estimation.window_residuals import WindowResiduals, window_residuals
from tp_jax.estimation.window_states import KINK, settle, state_steps

log = logging.getLogger(__name__)

#: Methods of optimistix, on residuals or on half their sum of squares.
Solver = optx.AbstractLeastSquaresSolver | optx.AbstractMinimiser
SOLVER_KINDS = (optx.AbstractLeastSquaresSolver, optx.AbstractMinimiser)

RUNS = 12  # of the method, with its coordinates scaled and the windows settled anew in between
TOGETHER = 1  # steps of the windows' states and the unknowns together before the first run
EVALUATIONS = 12  # of a run: windows that began in the wrong place hold up more of them
RANK = 1e-10  # relative eigenvalue of the information below which a direction is not scaled up
HELD = 1e-4  # weight of a coordinate's way from its origin: what no residual tells stays there

# By the root mean square: in the largest of ten thousand residuals a window's kink never ends. The
# other tolerance is that of the fit, see `_ending`.
_ENDS = {"rtol": 1e-8, "atol": 0.02, "norm": optx.rms_norm}


class DampedGaussNewton(optx.AbstractGaussNewton):
    """Gauss-Newton steps, halved until they go down: `optimistix.GaussNewton` takes them as they
    are, and where the model is wrong the first ones from afar go up."""

    rtol: float | Array
    atol: float | Array
    norm: Callable[[PyTree], Scalar]
    descent: optx.NewtonDescent = optx.NewtonDescent()
    search: optx.BacktrackingArmijo = optx.BacktrackingArmijo()
    verbose: Callable[..., None] = eqx.field(static=True, default=lambda **_: None)


#: Solvers by the name on the command line.
SOLVERS: dict[str, Solver] = {
    "variable-projection": VariableProjection(),
    "levenberg-marquardt": optx.LevenbergMarquardt(**_ENDS),
    "dogleg": optx.Dogleg(**_ENDS),
    "gauss-newton": DampedGaussNewton(**_ENDS),
    "bfgs": optx.BFGS(**_ENDS),
}


class _Scaled(eqx.Module):
    """The function in the method's coordinates z: u = origin + axes @ z, kept within bounds.

    unit: of a residual, so that what a wrong model leaves counts as noise.
    """

    windows: WindowResiduals
    origin: Float[Array, " u"]
    axes: Float[Array, "u u"]
    lower: Float[Array, " u"]
    upper: Float[Array, " u"]
    unit: Float[Array, ""]

    def unknowns(self, z: Float[Array, " u"]) -> Float[Array, " u"]:
        return jnp.clip(self.origin + self.axes @ z, self.lower, self.upper)

    def both(self, z: Float[Array, " u"]) -> tuple[Float[Array, " r"], Float[Array, "r u"]]:
        """Residuals and their derivatives."""
        free = self.origin + self.axes @ z
        inside = (free >= self.lower) & (free <= self.upper)
        r, J = self.windows.evaluate(self.unknowns(z))
        J = jnp.where(inside, J, 0.0) @ self.axes / self.unit
        held = HELD * jnp.eye(z.size)
        return jnp.concatenate([r / self.unit, held @ z]), jnp.concatenate([J, held])


def fit(
    problem: Problem,
    values: Values,
    unknowns: Sequence[Unknown],
    states: np.ndarray | None = None,
    *,
    solver: Solver,
    bounds: dict[str, tuple[float, float]] | None = None,
    priors: Sequence[GaussianPrior] = (),
    max_iterations: int = RUNS,
    evaluations: int = EVALUATIONS,
    ends: bool = False,
    tolerance: float = 0.02,
    relative: float = 1e-6,
    loss: Loss = "linear",
    blocks: int | None = None,
) -> Fit:
    """Fits unknowns and window states to all windows of a problem.

    Arguments and result are those of `variable_projection.fit`, and:

    Args:
        solver: of optimistix; `SOLVERS` has those with a name.
        max_iterations: runs of the method at most.
        evaluations: in a run at most.
        ends: whether the method is told to end where it has nothing to gain; otherwise it ends by
            its own tolerances.
        blocks: of windows that other horizons of the campaign have, so that one compiled program
            serves them all.
    """
    unknowns = tuple(unknowns)
    space = Coordinates(unknowns, [parameter(problem, u) for u in unknowns], bounds)
    low, high = space.ends.T
    # The windows of another horizon have states that fit neither the unknowns nor each other. A
    # step of all together brings them near; settled before it, many end in minima of their own.
    begun = variable_projection.fit(
        problem,
        values,
        unknowns,
        states,
        bounds=bounds,
        priors=priors,
        max_iterations=TOGETHER,
        tolerance=tolerance,
        relative=relative,
        loss=loss,
        kinks=True,
    )
    settled = np.array_equal(begun.values.table, values.table)  # no step was to be had otherwise
    values, at, lin = begun.values, begun.states, begun.linearisation
    passes: float = begun.evaluations
    slots = columns(unknowns)
    u = space.of(values.pick(unknowns))
    dof = max(problem.degrees_of_freedom(len(unknowns)), 1)
    cost: float = lin.cost() + prior_cost(priors, unknowns, u)
    to_bounds: bool = True
    converged, message = False, "The limit of runs was reached."
    if not np.isfinite(cost):
        message = "The start could not be integrated."
    for run in range(max_iterations):
        if not np.isfinite(cost):
            break
        slope = space.slope(values.pick(unknowns))
        kinked = state_steps(lin, np.zeros(problem.windows.n))[1] >= KINK if settled else None
        elim = eliminated(lin, unknowns, slope, kinked=kinked)
        normal = elim.summed(*prior_terms(priors, unknowns, u))
        # A wrong model scatters its optimum by as much more, as in `variable_projection`.
        unit: float = max(cost / dof, 1.0)
        enough: float = max(tolerance, NOTHING * unit, relative * cost)
        if run and normal.step(low - u, high - u).promise < enough:
            converged, message = True, "Another run of the method would gain nothing."
            break
        needed = max(blocks or 0, len(problem.blocks()))  # other noise may place them otherwise
        begin = at + elim.state_step
        windows = window_residuals(
            problem,
            values,
            begin,
            elim.gain_by_unknown(),
            unknowns,
            space.specs,
            priors,
            blocks=needed,
            loss=loss,
            enough=SETTLED * unit,
        )
        method = _ending(solver, enough / unit, len(unknowns)) if ends else solver
        scaled, moved = _scaled(windows, u, (low, high), normal, unit, to_bounds=to_bounds)
        new_u, spent = _run(method, evaluations, scaled, (low, high))
        passes += spent
        if not np.isfinite(new_u).all():
            message = "The method left the region that can be integrated."
            break
        new_values = values.put(unknowns, space.values(new_u))
        new_states = at + elim.following(new_u - u)
        new_lin = robust(problem.linearise(new_values, new_states, slots), loss)
        passes += 1.0
        if new_lin.complete.all():
            found = settle(problem, new_values, new_states, new_lin, slots, loss=loss, kinks=True)
            new_states, passes = found.states, passes + found.passes
        new_cost = new_lin.cost() + prior_cost(priors, unknowns, new_u)
        log.debug(
            "%s: run %d cost %.8g -> %.8g, %d evaluations",
            type(solver).__name__,
            run,
            cost,
            new_cost,
            spent,
        )
        if not new_cost < cost and moved:  # what went to a bound should have stayed where it was
            to_bounds = False
            continue
        if not new_cost < cost and not settled:
            found = settle(problem, values, at, lin, slots, loss=loss, kinks=True)
            at, passes, settled = found.states, passes + found.passes, True
            cost = lin.cost() + prior_cost(priors, unknowns, u)
            continue
        if not new_cost < cost:
            converged, message = run > 0, "Another run of the method gained nothing."
            break
        gained = cost - new_cost
        u, values, at, lin, cost = new_u, new_values, new_states, new_lin, new_cost
        settled = to_bounds = True
        if gained < enough:
            converged, message = True, "The last run of the method gained nothing."
            break
    near = [1e-3 * s.typical if s.transform == "identity" else 0.0 for s in space.specs]
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
        near=np.array(near),
    )


def _ending(solver: Solver, enough: float, unknowns: int) -> Solver:
    """The method, which ends where a step gains less than `enough`, in the residuals' units.

    A standard error of each unknown is a way of one in the method's coordinates, and costs one.
    """
    promises = isinstance(solver, VariableProjection)
    atol = enough if promises else math.sqrt(enough / max(unknowns, 1))
    return eqx.tree_at(lambda s: s.atol, solver, jnp.asarray(atol))


def _scaled(
    windows: WindowResiduals,
    u: np.ndarray,
    box: tuple[np.ndarray, np.ndarray],
    normal: NormalEquations,
    unit: float,
    *,
    to_bounds: bool,
) -> tuple[_Scaled, bool]:
    """Coordinates in which the information at the reference is one; whether an unknown was moved.

    An unknown at a bound is left out of them where the best step leaves it there. So is one that
    the step takes to a bound, and it is put there: a method that knows no bounds would go on
    against it. With `to_bounds` false only the first are left out.
    """
    low, high = box
    step = normal.step(low - u, high - u).du
    free = (step > low - u) & (step < high - u)
    if not to_bounds:
        free |= step != 0.0
    moved = bool((step[~free] != 0.0).any())
    u = np.where(free, u, np.clip(u + step, low, high))
    Hf = normal.part(free).information / unit
    scale = np.sqrt(np.maximum(np.diag(Hf), 1e-12 * max(np.diag(Hf).max(initial=0.0), 1e-300)))
    values, vectors = np.linalg.eigh(Hf / np.outer(scale, scale))
    values = np.maximum(values, RANK * values.max(initial=1e-300))
    axes = np.zeros_like(normal.H)
    axes[np.ix_(free, free)] = vectors / np.sqrt(values) / scale[:, None]
    scaled = _Scaled(windows, *map(jnp.asarray, (u, axes, low, high, math.sqrt(unit))))
    return scaled, moved


def _run(
    solver: Solver, evaluations: int, scaled: _Scaled, box: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, int]:
    """One run of a method; coordinates u within the box where it ended, evaluations spent."""
    best, spent = _search(solver, evaluations, scaled)
    return np.clip(np.asarray(best), *box), int(spent)


@eqx.filter_jit
def _search(
    solver: Solver, evaluations: int, scaled: _Scaled
) -> tuple[Float[Array, " u"], Int[Array, ""]]:
    """One run of a method of optimistix; coordinates u where it ended, evaluations spent."""

    # One integration gives residuals and Jacobian; a second rule of differentiation would take two.
    @jax.custom_jvp
    def residuals(z, scaled):
        return scaled.both(z)[0]

    @residuals.defjvp
    def _(primals, tangents):
        r, J = primals[1].both(primals[0])
        return r, J @ tangents[0]

    z0 = jnp.zeros_like(scaled.origin)
    options = {"max_steps": evaluations, "throw": False}
    if isinstance(solver, optx.AbstractMinimiser):
        half = lambda z, s: 0.5 * jnp.sum(residuals(z, s) ** 2)  # noqa: E731
        done = optx.minimise(half, solver, z0, scaled, **options)
    else:
        done = optx.least_squares(residuals, solver, z0, scaled, **options)
    return scaled.unknowns(done.value), done.stats["num_steps"]
