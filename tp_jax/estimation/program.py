"""The one compiled program: residuals of a block of windows and their Jacobian."""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from tp_jax.estimation.layout import Layout
from tp_jax.simulation.lanes import Lanes, Tolerances, integrate

TRACES: list[tuple] = []  # one entry per trace; tests count them


class Block(NamedTuple):
    """Data of a block of windows (lanes last).

    ts: (n, L) s; count: (L,); data: (n, 2, L) rad; weight: (n, 2, L), 1/sigma, 0 where there is
    no sample; prior: (4, L) smoothed readings and their rates; prior_weight: (4, L);
    pieces: (n - 1, 4, L) or None.
    """

    ts: Float[Array, "n L"]
    count: Int[Array, " L"]
    data: Float[Array, "n 2 L"]
    weight: Float[Array, "n 2 L"]
    prior: Float[Array, "4 L"]
    prior_weight: Float[Array, "4 L"]
    pieces: Float[Array, "n-1 4 L"] | None


class Linearised(NamedTuple):
    """Weighted residuals (model - data) of a block and their Jacobian.

    r: (L, n, 2); jac: (L, n, 2, c + d); prior_r: (L, 4); prior_jac: (L, 4, c + d);
    states: (L, n, c); complete: (L,); steps: (L,).
    """

    r: Float[Array, "L n 2"]
    jac: Float[Array, "L n 2 m"]
    prior_r: Float[Array, "L 4"]
    prior_jac: Float[Array, "L 4 m"]
    states: Float[Array, "L n c"]
    complete: Bool[Array, " L"]
    steps: Int[Array, " L"]


@functools.partial(jax.jit, static_argnums=(0, 1))
def linearise(
    layout: Layout,
    tolerances: Tolerances,
    p: Float[Array, "P L"],
    x0: Float[Array, "c L"],
    block: Block,
    directions: Int[Array, " d"],
) -> Linearised:
    """Integrates a block of windows and returns its residuals and their derivatives.

    Args:
        layout: structure of the model; static.
        tolerances: of the integration; static.
        p: all slots for every lane.
        x0: initial states.
        block: the data.
        directions: slots to differentiate by.
    """
    TRACES.append((layout, p.shape, block.ts.shape, directions.shape))
    slots = tuple(p)

    def field(t, y, q, piece, left):
        return layout.model(q, piece, left).derivative(t, y)

    eps = (layout.index["eps1"], layout.index["eps2"])
    run = integrate(
        field, slots, x0, Lanes(block.ts, block.count, block.pieces), eps, directions, tolerances
    )
    y = tuple(jnp.moveaxis(run.y, 2, 0).transpose(0, 2, 1))  # components (n, L)
    if block.pieces is None:
        piece, left = None, None
    else:
        last = jnp.concatenate([block.pieces, block.pieces[-1:]])
        piece = tuple(last.transpose(1, 0, 2))
        left = jnp.concatenate([block.ts[:-1], block.ts[-2:-1]])
    wide = tuple(jnp.broadcast_to(q, block.ts.shape) for q in slots)

    def readings(t, y, q):
        return jnp.stack(layout.model(q, piece, left).readings(t, y))

    value, by_state, by_slot = _derivatives(readings, block.ts, y, wide)
    s = run.s.transpose(2, 3, 1, 0)  # (c, m, n, L)
    jac = sum(by_state[k][:, None] * s[k][None] for k in range(len(y)))  # (2, m, n, L)
    nc = len(y)
    jac = jac.at[:, nc:].add(jnp.take(by_slot, directions, axis=1))
    weight = block.weight.transpose(1, 0, 2)
    r = (value - block.data.transpose(1, 0, 2)) * weight
    jac = jac * weight[:, None]

    start = jnp.eye(nc)
    prior_r, prior_jac = _prior(layout, slots, tuple(x0), block, piece, left, directions, start)
    return Linearised(
        r=r.transpose(2, 1, 0),
        jac=jac.transpose(3, 2, 0, 1),
        prior_r=prior_r,
        prior_jac=prior_jac,
        states=run.y,
        complete=run.complete & jnp.all(jnp.isfinite(r), axis=(0, 1)),
        steps=run.steps,
    )


def _derivatives(f, t, y, q):
    """Value, derivatives by component and by slot of `f(t, y, q)`, one tangent at a time."""
    one = jnp.ones_like(t)
    by_state = [
        jax.jvp(lambda x, k=k: f(t, (*y[:k], x, *y[k + 1 :]), q), (y[k],), (one,))[1]
        for k in range(len(y))
    ]
    by_slot = [
        jax.jvp(lambda x, k=k: f(t, y, (*q[:k], x, *q[k + 1 :])), (q[k],), (one,))[1]
        for k in range(len(q))
    ]
    return f(t, y, q), by_state, jnp.stack(by_slot, axis=1)


def _prior(layout, slots, x0, block, piece, left, directions, start):
    """Prior on a window's state, acting on readings: (h(x0, e), dh/dt) - smoothed readings."""
    first = None if piece is None else tuple(c[0] for c in piece)
    edge = None if left is None else left[0]

    def prior(t, y, q):
        def readings(t, y):
            return jnp.stack(layout.model(q, first, edge).readings(t, y))

        zero = jnp.zeros_like(t)
        rates = (y[2], y[3], *([zero] * (len(y) - 2)))
        h, dh = jax.jvp(readings, (t, y), (jnp.ones_like(t), rates))
        return jnp.concatenate([h, dh])  # (4, L)

    value, by_state, by_slot = _derivatives(prior, block.ts[0], x0, slots)
    chosen = jnp.take(by_slot, directions, axis=1)
    states = sum(by_state[k][:, None] * start[k][None, :, None] for k in range(len(x0)))
    jac = jnp.concatenate([states, chosen], axis=1)  # (4, c + d, L)
    r = (value - block.prior) * block.prior_weight
    return r.T, (jac * block.prior_weight[:, None]).transpose(2, 0, 1)
