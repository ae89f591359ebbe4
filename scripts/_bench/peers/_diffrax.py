"""Base of both diffrax peers: the equations, and one program each for a run, a sweep, tangents.

Compiled once for a number of samples; parameters, eps and tolerance are data. XLA runs their loops
operation by operation, as it does for whoever sets no flag; with one in `XLA_FLAGS`
(`xla_cpu_small_while_loop_byte_threshold`) they are several times faster.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from ..equations import TWO_OVER_PI
from ..peer import Peer, cores
from ..problem import VARIED


def field(t: Any, y: Any, args: Any) -> Any:
    """Right-hand side; `args` is a row of parameters and eps."""
    (k, A, B1, B2, c1, M1, Tv, Ts1, Tst, T0, omega), eps = args
    q1, _, v1, v2 = y
    contact = Tv * v2 + TWO_OVER_PI * Ts1 * jnp.arctan(eps * v2)
    contact -= Tst * jnp.expm1(-T0 * jnp.abs(v2)) * jnp.sign(v2)
    bearing = c1 * v1 + TWO_OVER_PI * M1 * jnp.arctan(eps * v1)
    a1 = (k * (A * jnp.sin(omega * t) - q1) - bearing + contact) / B1
    return jnp.stack([v1, v2, a1, -contact / B2 - a1])


def integrate(solver: Any, parameters: Any, y0: Any, eps: Any, ts: Any, tol: Any) -> Any:
    """Angles (n, 2); infinite from where it failed."""
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        solver,
        t0=ts[0],
        t1=ts[-1],
        dt0=1e-6,
        y0=y0,
        args=(parameters, eps),
        saveat=diffrax.SaveAt(ts=ts),
        stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
        adjoint=diffrax.ForwardMode(),
        max_steps=None,
        throw=False,
    )
    return solution.ys[:, :2]


def peer(name: str, solver: Any) -> Peer:
    """The peer of a solver."""
    one = partial(integrate, solver)

    @jax.jit
    def run(parameters, eps, ts, tol):
        return one(parameters, jnp.zeros(4), eps, ts, tol)

    many = jax.jit(jax.vmap(run, in_axes=(0, None, None, None)))

    def sweep(table, eps, ts, tol):
        # one program on one core waits for its slowest lane only; as many programs as cores, since
        # XLA does not share such a loop out among threads
        parts = np.array_split(table, min(cores(), len(table)))
        with ThreadPoolExecutor(len(parts)) as pool:
            angles = pool.map(lambda part: np.asarray(many(part, eps, ts, tol)), parts)
            return np.concatenate(list(angles))

    @jax.jit
    def tangents(parameters, eps, ts, tol):
        def of(direction):
            varied, y0 = direction[: len(VARIED)], direction[len(VARIED) :]
            return one(jnp.append(varied, parameters[-1]), y0, eps, ts, tol)

        return jax.jacfwd(of)(jnp.append(parameters[:-1], jnp.zeros(4)))

    return Peer(
        name,
        lambda *args: np.asarray(run(*args)),
        sweep,
        lambda *args: np.asarray(tangents(*args)),
        threads=cores(),
    )
