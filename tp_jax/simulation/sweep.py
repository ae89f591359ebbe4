"""Many pendulums at once."""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.simulation.control import Control
from tp_jax.simulation.parts import take_apart
from tp_jax.simulation.runs import Ran, integrate
from tp_jax.simulation.solve import checked, samples_per_step

WIDTH = 64
"""Lanes side by side on a CPU: as many as fill its vector units and fit its fastest memory."""


PIECE = 1 << 25
"""Bytes of motions that one call returns on a CPU, at most: what is larger is fresh memory every
time, which the system clears first."""


class Sweep(NamedTuple):
    """What `sweep` returns.

    t: (n,) s; phi1, phi2: (N, n) rad; omega1, omega2: (N, n) rad/s, None unless asked for; steps:
    (N,) attempted; complete: (N,) False where a run was given up, and infinite from there on.
    """

    t: Float[Array, " n"]
    phi1: Float[Array, "N n"]
    phi2: Float[Array, "N n"]
    omega1: Float[Array, "N n"] | None
    omega2: Float[Array, "N n"] | None
    steps: Int[Array, " N"]
    complete: Bool[Array, " N"]


def sweep(
    models: AbstractTorsionPendulum,
    ts: Float[Array, " n"],
    y0: Float[Array, "..."] | None = None,
    *,
    tolerance: float = 1e-6,
    velocities: bool = True,
    max_steps: int = 1_000_000,
    threads: int | None = None,
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
    states = np.zeros(parts.n_states) if y0 is None else np.asarray(y0, float)
    for name, v in zip(parts.names, parts.values, strict=True):
        if np.ndim(v) > 1:
            raise ValueError(
                f"Numbers of `models` must have shape () or (N,), but {name} has shape {v.shape}."
            )
    sizes = {np.shape(v)[0] for v in parts.values if np.ndim(v)}
    sizes |= {len(states)} if states.ndim == 2 else set()
    if len(sizes) > 1:
        raise ValueError(f"All members must be equally many, but there are {sorted(sizes)}.")
    if sizes == {0}:
        raise ValueError("Argument `models` must hold at least one pendulum.")
    if states.shape[-1:] != (parts.n_states,) or states.ndim > 2:
        raise ValueError(
            f"Argument `y0` must have shape ({parts.n_states},) or (N, {parts.n_states}), "
            f"but has {states.shape}."
        )
    many = sizes.pop() if sizes else 1
    p = np.stack([np.broadcast_to(np.asarray(v, float), (many,)) for v in parts.values])
    states = np.broadcast_to(states, (many, parts.n_states)).T
    on_cpu = jax.default_backend() == "cpu"
    shares = min(threads or _cores(), -(-many // WIDTH)) if on_cpu else 1
    width = WIDTH if on_cpu else many
    control = Control(angle=jnp.asarray(tolerance))
    # Rounded up, so that the next size is not another program; the rest has nothing to do.
    room = 1 << (-(-many // shares) - 1).bit_length()
    y = np.empty((many, ts.size, 4 if velocities else 2))
    steps, complete = np.empty(many, int), np.empty(many, bool)
    if on_cpu:
        most = PIECE // y[0].nbytes
        room = min(room, max(WIDTH, 1 << max(most, 1).bit_length() - 1))

    def several(turn: np.ndarray) -> None:
        for first in range(0, len(turn), room):
            part = turn[first : first + room]
            index = np.concatenate([part, np.repeat(part[:1], room - len(part))])
            done = _run(
                parts.template, p[:, index], states[:, index], ts, control,
                jnp.asarray(max_steps), jnp.asarray(len(part)), width, velocities,
            )  # fmt: skip
            for whole, its in ((y, done.y), (steps, done.steps), (complete, done.complete)):
                whole[part] = np.asarray(its)[: len(part)]

    # Every other run to the same thread: neighbours tend to take equally long.
    with ThreadPoolExecutor(shares) as pool:
        list(pool.map(several, [np.arange(many)[i::shares] for i in range(shares)]))
    omegas = (y[..., 2], y[..., 3]) if velocities else (None, None)
    return Sweep(np.asarray(ts), y[..., 0], y[..., 1], *omegas, steps, complete)


@eqx.filter_jit
def _run(template, p, y0, ts, control, max_steps, active, width, velocities) -> Ran:
    parts = take_apart(template)
    q = tuple(p)
    return integrate(
        parts.field, q, y0, ts, (q[parts.eps[0]], q[parts.eps[1]]), control, width=width,
        per_step=samples_per_step(ts.size), velocities=velocities, max_steps=max_steps,
        active=active,
    )  # fmt: skip


def _cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
