"""Many pendulums at once."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from tp_jax._compiler import compiler_options
from tp_jax.model.arrays import AnyArray
from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.batch import gathered, in_pieces, lanes
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.runs import Ran, integrate
from tp_jax.simulation.solve import WIDTH, checked, samples_per_step


class Sweep(NamedTuple):
    """Result of `sweep`.

    t: (n,) s; phi1, phi2: (N, n) rad; omega1, omega2: (N, n) rad/s, None unless asked for; steps:
    (N,) attempted; complete: (N,) False where a run was given up, and infinite from there on.
    """

    t: Float[AnyArray, " n"]
    phi1: Float[AnyArray, "N n"]
    phi2: Float[AnyArray, "N n"]
    omega1: Float[AnyArray, "N n"] | None
    omega2: Float[AnyArray, "N n"] | None
    steps: Int[AnyArray, " N"]
    complete: Bool[AnyArray, " N"]


def sweep(
    models: AbstractTorsionPendulum,
    ts: Float[AnyArray, " n"] | Sequence[float],
    y0: Float[AnyArray, "..."] | None = None,
    *,
    tolerance: float = 1e-6,
    velocities: bool = True,
    max_steps: int = 1_000_000,
    threads: int | None = None,
    control: Control | None = None,
) -> Sweep:
    """Motions of many pendulums that differ in their numbers, on all cores or on the GPU.

    A run that sticks, crawls or fails holds up no other. What is compiled depends on the model's
    structure, the number of samples and, up to a few hundred, the number of runs, rounded up to a
    power of two.

    Args:
        models: one pendulum whose numbers are (N,) or shared by all, as `jax.vmap` over a
            function that builds one returns it.
        ts: times [s], increasing, the same for all.
        y0: initial states, (m,) or (N, m); rest if None.
        tolerance: error of an angle in one step [rad].
        velocities: whether to return them; a sweep without takes an eighth less.
        max_steps: a run that needs more attempts is given up.
        threads: of a CPU; as many as there are cores if None.
        control: what else bounds a step (`tolerance` takes its `angle`'s place).

    Returns:
        A `Sweep`.

    Raises:
        ValueError: where shapes do not fit.

    Example:
        >>> import jax, numpy as np, tp_jax as tp
        >>> of = lambda k: tp.presets.double_pendulum(**tp.presets.values("bench") | {"k": k})
        >>> many = tp.sweep(jax.vmap(of)(np.linspace(0.4, 0.5, 8)), np.linspace(0.0, 0.2, 51))
        >>> many.phi1.shape
        (8, 51)
    """
    parts = take_apart(models)
    ts, _ = checked(models, ts, None)
    p, states = gathered(parts, y0)
    many = states.shape[1]
    width, compiled = lanes(WIDTH, many), _compiled()
    control = (control or Control())._replace(angle=jnp.asarray(tolerance))
    y = np.empty((many, ts.size, 4 if velocities else 2))
    steps, complete = np.empty(many, int), np.empty(many, bool)

    def run(index: np.ndarray, active: int) -> None:
        done = compiled(
            parts.template,
            p[:, index],
            states[:, index],
            ts,
            control,
            jnp.asarray(max_steps),
            jnp.asarray(active),
            width,
            velocities,
        )
        for whole, its in ((y, done.y), (steps, done.steps), (complete, done.complete)):
            whole[index[:active]] = np.asarray(its)[:active]

    in_pieces(run, many, width=width, bytes_each=y[0].nbytes, threads=threads)
    omegas = (y[..., 2], y[..., 3]) if velocities else (None, None)
    return Sweep(np.asarray(ts), y[..., 0], y[..., 1], *omegas, steps, complete)


@functools.cache
def _compiled():
    """`_run`, compiled for the processor that there is, which is asked at the first call."""
    # equinox hands such options on to `jax.jit`; its overloads do not tell of them
    options = compiler_options()
    return eqx.filter_jit(_run, compiler_options=options)  # pyright: ignore[reportCallIssue]


def _run(template, p, y0, ts, control, max_steps, active, width, velocities) -> Ran:
    parts = take_apart(template)
    q = tuple(p)
    return integrate(
        parts.field,
        q,
        y0,
        ts,
        (q[parts.eps[0]], q[parts.eps[1]]),
        control,
        width=width,
        per_step=samples_per_step(ts.size),
        velocities=velocities,
        max_steps=max_steps,
        active=active,
    )
