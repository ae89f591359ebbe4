"""Simulation of one pendulum."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jax.custom_batching import custom_vmap
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray, Real
from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.batch import lanes
from tp_jax.simulation.control import Control
from tp_jax.simulation.one_piece import loops_in_one_piece
from tp_jax.simulation.parts import Parts, take_apart
from tp_jax.simulation.runs import integrate

if TYPE_CHECKING:  # half a second that only those pay who use its solvers
    import diffrax


WIDTH = 64
"""Lanes side by side on a CPU: as many as fill its vector units and fit its fastest memory."""


class Trajectory(NamedTuple):
    """Result of `simulate`; every field (n,), in a sweep (N, n) but for t.

    t [s]; phi1, phi2 [rad], the rider's angle relative to the column; omega1, omega2 [rad/s].
    """

    t: AnyArray
    phi1: AnyArray
    phi2: AnyArray
    omega1: AnyArray
    omega2: AnyArray


def simulate(
    model: AbstractTorsionPendulum,
    ts: Float[AnyArray, " n"] | Sequence[float],
    y0: Float[AnyArray, " m"] | Sequence[float] | None = None,
    *,
    tolerance: Real = 1e-8,
    solver: diffrax.AbstractSolver | None = None,
    max_steps: int = 1_000_000,
) -> Trajectory:
    """Motion of a pendulum at given times, by `diffrax.diffeqsolve`.

    With the package's `Rodas4` and `ReversalController`, which know dry friction. Works under
    `jit`, `vmap`, `jvp` and `grad`, in the model's numbers, `y0` and `ts` (not in the knots of a
    measured drive). Derivatives are those of the steps taken; all numbers together cost a few runs.
    For many pendulums at once `sweep` is faster, for derivatives and whether to trust them,
    `sensitivities`.

    Args:
        model: `DoubleTorsionPendulum` or `SingleTorsionPendulum`.
        ts: times [s], increasing; the motion starts at the first.
        y0: phi1, phi2 [rad], omega1, omega2 [rad/s] at the first time (and the effects' own
            states, where they have any); rest if None.
        tolerance: error of an angle in one step [rad]. That of a whole run of ten seconds is
            about the same; `scripts/bench` shows it.
        solver: another solver of diffrax, with its `PIDController` and `tolerance` both relative
            and absolute.
        max_steps: after so many steps the rest of the trajectory is infinite.

    Returns:
        A `Trajectory`. Angles as they are, without the sensors; see `readings`.

    Raises:
        ValueError: `ts` or `y0` has a wrong shape, or derivatives by `ts` are asked of a model
            whose effects have states of their own.

    Example:
        >>> import numpy as np, tp_jax as tp
        >>> motion = tp.simulate(tp.presets.get("bench"), np.linspace(0.0, 1.0, 251))
        >>> motion.phi1.shape
        (251,)
    """
    ts, y0 = checked(model, ts, y0)
    parts = take_apart(model)
    if any(v.ndim for v in parts.values):
        raise ValueError(
            "Argument `model` must be one pendulum, but its numbers are arrays; use `sweep`."
        )
    every = [*parts.values, *y0, tolerance]
    if any(isinstance(x, Tracer) for x in every):
        # One by one, for then it is seen by which of them derivatives are asked for.
        inputs = tuple(jnp.asarray(x, dtype=float) for x in every)
    else:
        inputs = np.stack([np.asarray(x, dtype=float) for x in every])
    ys = _run(parts.template, inputs[:-1], ts, inputs[-1], solver, max_steps)
    return Trajectory(jnp.asarray(ts), ys[:, 0], ys[:, 1], ys[:, 2], ys[:, 3])


def accelerations(model: AbstractTorsionPendulum, motion: Trajectory) -> tuple[Array, Array]:
    """Accelerations of the column and, against it, of the rider.

    Args:
        model: the pendulum that moved; without effects that have states of their own, which a
            trajectory does not hold.
        motion: what `simulate` returned for it.

    Returns:
        d omega1/dt and d omega2/dt [rad/s^2], each of the shape of `motion.t`.

    Raises:
        ValueError: the pendulum has effects with states of their own.

    Example:
        >>> import numpy as np, tp_jax as tp
        >>> bench = tp.presets.get("bench")
        >>> a1, a2 = tp.accelerations(bench, tp.simulate(bench, np.linspace(0.0, 1.0, 251)))
        >>> a1.shape
        (251,)
    """
    if model.n_states != 4:
        raise ValueError(
            "Argument `model` must have no effects with states of their own, but has "
            f"{model.n_states - 4} of them, which a trajectory does not hold."
        )
    state = (motion.phi1, motion.phi2, motion.omega1, motion.omega2)
    rates = model.derivative(jnp.asarray(motion.t), tuple(jnp.asarray(each) for each in state))
    return rates[2], rates[3]


@eqx.filter_jit
def _run(template, inputs, ts, tolerance, solver, max_steps) -> Array:
    parts = take_apart(template)
    if solver is None:
        return _own(parts, max_steps)(inputs, ts, tolerance)
    return _with_diffrax(parts, solver, max_steps)(jnp.stack(inputs), ts, tolerance)


def checked(
    model: AbstractTorsionPendulum,
    ts: AnyArray | Sequence[float],
    y0: AnyArray | Sequence[float] | None,
) -> tuple[Float[AnyArray, " n"], Float[AnyArray, " m"]]:
    """Times and initial state as arrays, rest if None; ValueError where their shapes are wrong."""
    # What is not traced stays on the host: a small operation on a device costs many steps.
    here = np if not isinstance(ts, Tracer) else jnp
    ts = here.asarray(ts, dtype=float)
    if ts.ndim != 1 or ts.size < 2:
        raise ValueError(
            f"Argument `ts` must hold at least two times in one row, but has shape {ts.shape}."
        )
    # under `jit` they are not known yet
    if here is np and not (ts[1:] > ts[:-1]).all():
        raise ValueError("Argument `ts` must increase from each time to the next.")
    here = np if not isinstance(y0, Tracer) else jnp
    y0 = np.zeros(model.n_states) if y0 is None else here.asarray(y0, dtype=float)
    if y0.shape != (model.n_states,):
        raise ValueError(f"Argument `y0` must have shape ({model.n_states},), but has {y0.shape}.")
    return ts, y0


def samples_per_step(n: int) -> int:
    """Returns how many samples a step may cross: more where dense, and each costs a little."""
    return 2 if n <= 4000 else 4


def _states(parts: Parts, solver, controller, max_steps: int) -> Callable:
    """Runs (inputs, ts, tolerance) -> states (n, 4) by diffrax."""
    import diffrax

    def solve(inputs, ts, tolerance):
        model = parts.model_of(tuple(inputs[: len(parts.values)]))
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda t, y, _: model.derivative(t, y)),
            solver,
            t0=ts[0],
            t1=ts[-1],
            dt0=(ts[1] - ts[0]) * 1e-2,
            y0=tuple(inputs[len(parts.values) :]),
            saveat=diffrax.SaveAt(ts=ts),
            stepsize_controller=controller(model, tolerance),
            adjoint=diffrax.ForwardMode(),
            max_steps=max_steps,
            throw=False,
        )
        assert solution.ys is not None  # `saveat` has times
        return jnp.stack(solution.ys[:4], axis=1)

    return solve


def _own(parts: Parts, max_steps: int) -> Callable:
    """Runs (inputs, ts, tolerance) -> states (n, 4) by the package's own method.

    Alone by diffrax; many by the batch engine, which takes the same steps. That gives columns of
    the Jacobian in addition to the motion; a rule whose tangent is a product with it can be
    transposed, which a loop of unknown length cannot. Inputs are an array, or numbers one by one:
    then only those columns are made that are asked for.
    """
    from tp_jax.simulation.reversal_controller import ReversalController
    from tp_jax.simulation.rodas4 import Rodas4

    n_p = len(parts.values)

    def engine(inputs, ts, tolerance, directions):
        p, y0 = inputs[:, :n_p].T, inputs[:, n_p:].T
        eps = p[parts.eps[0]], p[parts.eps[1]]
        return integrate(
            parts.field,
            tuple(p),
            y0,
            ts,
            eps,
            Control(angle=tolerance),
            directions=directions,
            width=lanes(WIDTH, len(inputs)),
            per_step=samples_per_step(ts.size),
            max_steps=max_steps,
        )

    def motions(inputs, ts, tolerance):
        return engine(inputs, ts, tolerance, None).y

    alone = _states(parts, Rodas4(), ReversalController, max_steps)
    states = _of_one(motions, functools.partial(loops_in_one_piece, alone))

    @jax.custom_jvp
    def run(inputs, ts, tolerance):
        return states(jnp.stack(inputs), ts, tolerance)

    @functools.partial(run.defjvp, symbolic_zeros=True)
    def _(primals, tangents):
        inputs, ts, tolerance = primals
        asked = [i for i, t in enumerate(tangents[0]) if not isinstance(t, SymbolicZero)]
        numbers = [i for i in asked if i < n_p]

        def derived(inputs, ts, tolerance):
            ran = engine(inputs, ts, tolerance, jnp.array(numbers, dtype=int))
            return ran.y, ran.s

        y, s = _of_one(derived)(jnp.stack(inputs), ts, tolerance)
        # the engine's columns begin with the initial state
        place = [i - n_p if i >= n_p else parts.n_states + numbers.index(i) for i in asked]
        change = jnp.zeros_like(y)
        if asked:
            change += s[..., np.array(place)] @ jnp.stack([tangents[0][i] for i in asked])
        if not isinstance(tangents[1], SymbolicZero):
            change += _by_times(parts, inputs, ts, y, s[..., : parts.n_states], tangents[1])
        return y, change

    return lambda inputs, ts, tolerance: run(tuple(inputs), ts, tolerance)


def _by_times(parts: Parts, inputs, ts: Array, y: Array, by_start: Array, change: Array) -> Array:
    """Change (n, 4) of the states where the times (n,) change; the state at the first stays.

    A sample that comes later is further along the motion; a run that begins later is everywhere
    where it would be if its start had been moved back along the motion.

    Args:
        inputs: numbers of the model, then the initial state.
        y: states (n, 4). by_start: (n, 4, 4) their derivatives by the initial state.
    """
    if parts.n_states != 4:
        raise ValueError(
            "Derivatives by `ts` need a model without effects that have states of their own, but "
            f"this one has {parts.n_states - 4} such states; leave `ts` out of what you "
            "differentiate by."
        )
    model = parts.model_of(tuple(inputs[: len(parts.values)]))
    rates = jnp.stack(jnp.broadcast_arrays(*model.derivative(ts, tuple(y.T))), axis=1)
    return rates * change[:, None] - by_start @ (rates[0] * change[0])


def _of_one(many: Callable, alone: Callable | None = None) -> Callable:
    """A function of one run's (inputs, ts, tolerance) that calls `many` where it is mapped.

    Args:
        many: of inputs (N, m).
        alone: of inputs (m,); `many` of one if None.
    """

    def batched(function: Callable, axes: int) -> Callable:
        """`function` of inputs with so many axes before their last, with the rule."""
        function = custom_vmap(function)

        @function.def_vmap
        def _(size, mapped, *args):
            if mapped[1] or mapped[2]:  # times of their own: one after the other
                args = [
                    x if m else jnp.stack([x] * size) for x, m in zip(args, mapped, strict=True)
                ]
                found = jax.lax.map(lambda each: function(*each), tuple(args))
            else:
                inputs, ts, tolerance = args
                several = inputs.reshape(-1, inputs.shape[-1])
                found = flat(several, ts, tolerance)
                if axes:
                    found = jax.tree.map(lambda x: x.reshape(size, -1, *x.shape[1:]), found)
            return found, jax.tree.map(lambda _: True, found)

        return function

    def of_one(inputs, ts, tolerance):
        return jax.tree.map(lambda x: x[0], flat(inputs[None], ts, tolerance))

    flat = batched(many, 1)
    return batched(alone or of_one, 0)


def _with_diffrax(parts: Parts, solver, max_steps: int) -> Callable:
    """Runs (inputs, ts, tolerance) -> states (n, 4) with another solver of diffrax.

    Its adjoints offer one mode each; the Jacobian is built column by column in forward mode.
    """
    import diffrax

    def controller(model, tolerance):  # noqa: ARG001
        return diffrax.PIDController(rtol=tolerance, atol=tolerance)

    # Not in one piece: an implicit solver calls LAPACK, which such a loop cannot.
    solve = _states(parts, solver, controller, max_steps)

    @jax.custom_jvp
    def run(inputs, ts, tolerance):
        return solve(inputs, ts, tolerance)

    @functools.partial(run.defjvp, symbolic_zeros=True)
    def _(primals, tangents):
        inputs, ts, tolerance = primals
        forward = lambda x: solve(x, ts, tolerance)  # noqa: E731
        y, jac = forward(inputs), jax.jacfwd(forward)(inputs)
        change = jnp.zeros_like(y)
        if not isinstance(tangents[0], SymbolicZero):
            change += jac @ tangents[0]
        if not isinstance(tangents[1], SymbolicZero):
            by_start = jac[..., len(parts.values) :]
            change += _by_times(parts, inputs, ts, y, by_start, tangents[1])
        return y, change

    return run
