"""Simulation of one pendulum with diffrax."""

from functools import partial
from typing import Any, NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float

from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.rosenbrock import Rosenbrock


class Trajectory(NamedTuple):
    """What `simulate` returns; every field (n,).

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
    solver: diffrax.AbstractSolver | None = None,
    rtol: float = 1e-8,
    atol: float = 1e-9,
    max_steps: int = 1_000_000,
) -> Trajectory:
    """Motion of a pendulum at given times.

    Works under `jit`, `vmap`, `jvp` and `grad`, in the model's numbers and `y0`. Derivatives are
    those of the numerical solution in forward mode; they cost one sweep for each such number.

    Args:
        model: `DoubleTorsionPendulum` or `SingleTorsionPendulum`.
        ts: times [s], increasing; the motion starts at the first.
        y0: phi1, phi2 [rad], omega1, omega2 [rad/s] at the first time (and the effects' own
            states, where they have any); rest if None.
        solver: a diffrax solver; the linearly implicit `Rosenbrock` if None.
        rtol, atol: tolerances of a step.
        max_steps: after so many steps the rest of the trajectory is infinite.

    Returns:
        A `Trajectory`. Angles as they are, without the sensors; see `readings`.

    Example:
        >>> import numpy as np, tp_jax as tp
        >>> motion = tp.simulate(tp.presets.get("bench"), np.linspace(0.0, 1.0, 251))
        >>> motion.phi1.shape
        (251,)
    """
    solver = Rosenbrock() if solver is None else solver
    ts = jnp.asarray(ts, dtype=float)
    if ts.ndim != 1 or ts.size < 2:
        raise ValueError(
            f"Argument `ts` must hold at least two times in one row, but has shape {ts.shape}."
        )
    y0 = jnp.zeros(model.n_states) if y0 is None else jnp.asarray(y0, dtype=float)
    if y0.shape != (model.n_states,):
        raise ValueError(f"Argument `y0` must have shape ({model.n_states},), but has {y0.shape}.")
    arrays, static = eqx.partition(model, eqx.is_inexact_array)
    leaves, tree = jax.tree.flatten(arrays)
    run = partial(_integrate, tree, static, solver, rtol, atol, max_steps)
    ys = _forward_differentiable(run, (tuple(leaves), y0), ts)
    return Trajectory(ts, ys[:, 0], ys[:, 1], ys[:, 2], ys[:, 3])


def _integrate(tree, static, solver, rtol, atol, max_steps, inputs, ts, adjoint):
    leaves, y0 = inputs
    model = eqx.combine(jax.tree.unflatten(tree, leaves), static)
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(model.vector_field),
        solver,
        t0=ts[0],
        t1=ts[-1],
        dt0=(ts[1] - ts[0]) * 1e-2,
        y0=y0,
        saveat=diffrax.SaveAt(ts=ts),
        stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol),
        adjoint=adjoint,
        max_steps=max_steps,
        throw=False,
    )
    return solution.ys


def _forward_differentiable(run: Any, inputs: Any, ts: Array) -> Array:
    """Runs with forward-mode tangents, made linear in them so that they can be transposed.

    diffrax's adjoints offer one mode each. A custom rule whose tangent is a product with the
    Jacobian, built column by column in forward mode, serves both modes. Sample times carry no
    tangent.
    """

    @jax.custom_jvp
    def solve(inputs, ts):
        return run(inputs, ts, diffrax.ForwardMode())

    @solve.defjvp
    def _(primals, tangents):
        inputs, ts = primals
        flat, unflatten = ravel_pytree(inputs)
        direction, _ = ravel_pytree(tangents[0])
        forward = lambda x: run(unflatten(x), ts, diffrax.ForwardMode())  # noqa: E731
        return forward(flat), jax.jacfwd(forward)(flat) @ direction

    return solve(inputs, ts)
