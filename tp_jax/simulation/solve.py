"""Simulation of one pendulum."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import Parts, take_apart
from tp_jax.simulation.runs import integrate

if TYPE_CHECKING:  # half a second that only those pay who use its solvers
    import diffrax


class Trajectory(NamedTuple):
    """What `simulate` returns; every field (n,), in a sweep (N, n) but for t.

    t [s]; phi1, phi2 [rad], the rider's angle relative to the column; omega1, omega2 [rad/s].
    """

    t: Array
    phi1: Array
    phi2: Array
    omega1: Array
    omega2: Array


def simulate(
    model: AbstractTorsionPendulum,
    ts: Float[Array, " n"],
    y0: Float[Array, " m"] | None = None,
    *,
    tolerance: float = 1e-8,
    solver: diffrax.AbstractSolver | None = None,
    max_steps: int = 1_000_000,
) -> Trajectory:
    """Motion of a pendulum at given times.

    Works under `jit`, `vmap`, `jvp` and `grad`, in the model's numbers and `y0` (not in the knots
    of a measured drive). Derivatives are those of the steps taken; all numbers together cost
    a few runs. For many pendulums at once `sweep` is faster, for derivatives with a word on
    whether to trust them, `sensitivities`.

    Args:
        model: `DoubleTorsionPendulum` or `SingleTorsionPendulum`.
        ts: times [s], increasing; the motion starts at the first.
        y0: phi1, phi2 [rad], omega1, omega2 [rad/s] at the first time (and the effects' own
            states, where they have any); rest if None.
        tolerance: error of an angle in one step [rad]. That of a whole run of ten seconds is
            about the same; `scripts/bench` shows it.
        solver: a diffrax solver instead of the package's own engine, with `tolerance` both
            relative and absolute.
        max_steps: after so many steps the rest of the trajectory is infinite.

    Returns:
        A `Trajectory`. Angles as they are, without the sensors; see `readings`.

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
    inputs = jnp.stack([*parts.values, *y0])
    ys = _run(parts.template, inputs, ts, jnp.asarray(tolerance, float), solver, max_steps)
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
    rates = model.derivative(motion.t, tuple(jnp.asarray(each) for each in state))
    return rates[2], rates[3]


@eqx.filter_jit
def _run(template, inputs, ts, tolerance, solver, max_steps) -> Array:
    parts = take_apart(template)
    if solver is None:
        return _own(parts, max_steps)(inputs, ts, tolerance)
    return _with_diffrax(parts, solver, max_steps)(inputs, ts, tolerance)


def checked(
    model: AbstractTorsionPendulum, ts: Array, y0: Array | None
) -> tuple[Float[Array, " n"], Float[Array, " m"]]:
    """Times and initial state as arrays, rest if None; ValueError where their shapes are wrong."""
    # What is not traced stays on the host: a small operation on a device costs many steps.
    here = np if not isinstance(ts, jax.core.Tracer) else jnp
    ts = here.asarray(ts, dtype=float)
    if ts.ndim != 1 or ts.size < 2:
        raise ValueError(
            f"Argument `ts` must hold at least two times in one row, but has shape {ts.shape}."
        )
    # under `jit` they are not known yet
    if here is np and not (ts[1:] > ts[:-1]).all():
        raise ValueError("Argument `ts` must increase from each time to the next.")
    here = np if not isinstance(y0, jax.core.Tracer) else jnp
    y0 = np.zeros(model.n_states) if y0 is None else here.asarray(y0, dtype=float)
    if y0.shape != (model.n_states,):
        raise ValueError(f"Argument `y0` must have shape ({model.n_states},), but has {y0.shape}.")
    return ts, y0


def samples_per_step(n: int) -> int:
    """How many samples a step may cross: more where they are dense, and each costs a little."""
    return 2 if n <= 4000 else 4


def _own(parts: Parts, max_steps: int) -> Callable:
    """Runs (inputs, ts, tolerance) -> states (n, 4) on the package's own engine.

    The engine gives all columns of the Jacobian beside the motion; a rule whose tangent is a
    product with it can be transposed, which a loop of unknown length cannot.
    """
    n_p = len(parts.values)

    def engine(inputs, ts, tolerance, directions):
        p, y0 = inputs[:n_p, None], inputs[n_p:, None]
        eps = p[parts.eps[0]], p[parts.eps[1]]
        return integrate(
            parts.field, tuple(p), y0, ts, eps, Control(angle=tolerance),
            directions=directions, width=1, per_step=samples_per_step(ts.size), max_steps=max_steps,
        )  # fmt: skip

    @jax.custom_jvp
    def run(inputs, ts, tolerance):
        return engine(inputs, ts, tolerance, None).y[0]

    @run.defjvp
    def _(primals, tangents):
        inputs, ts, tolerance = primals
        ran = engine(inputs, ts, tolerance, jnp.arange(n_p))
        # the engine's columns begin with the initial state
        return ran.y[0], ran.s[0] @ jnp.roll(tangents[0], inputs.size - n_p)

    return run


def _with_diffrax(parts: Parts, solver, max_steps: int) -> Callable:
    """The same with a solver of diffrax.

    Its adjoints offer one mode each; the Jacobian is built column by column in forward mode.
    """
    import diffrax

    n_p = len(parts.values)

    def solve(inputs, ts, tolerance):
        p = tuple(inputs[:n_p])
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda t, y, _: jnp.stack(parts.field(t, tuple(y), p))),
            solver,
            t0=ts[0],
            t1=ts[-1],
            dt0=(ts[1] - ts[0]) * 1e-2,
            y0=inputs[n_p:],
            saveat=diffrax.SaveAt(ts=ts),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            adjoint=diffrax.ForwardMode(),
            max_steps=max_steps,
            throw=False,
        )
        return solution.ys[:, :4]

    @jax.custom_jvp
    def run(inputs, ts, tolerance):
        return solve(inputs, ts, tolerance)

    @run.defjvp
    def _(primals, tangents):
        inputs, ts, tolerance = primals
        forward = lambda x: solve(x, ts, tolerance)  # noqa: E731
        return forward(inputs), jax.jacfwd(forward)(inputs) @ tangents[0]

    return run
