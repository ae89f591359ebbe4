"""The one compiled program: residuals of a block of windows and their Jacobian."""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from tp_jax.estimation.layout import Layout
from tp_jax.simulation.lanes import Lanes, Motion, Tolerances, integrate

NONE = frozenset[str]()
CONTACT = frozenset({"contact"})
SENSORS = frozenset({"sensor1", "sensor2", "clock"})
COLUMN = frozenset({"clock", "phase", "drive", "spring", "bearing", "column"})

TRACES: list[tuple] = []  # one entry per trace; tests count them


class Block(NamedTuple):
    """Data of a block of windows (lanes last; a lane holds several windows, see `Lanes`).

    ts: (n, L) s; count: (L,); start: (n, L); data: (n, 2, L) rad; weight: (n, 2, L), 1/sigma, 0
    where there is no sample; prior: (n, 4, L) smoothed readings and their rates; prior_weight:
    (n, 4, L), 0 but at starts; pieces: (n - 1, 4, L) or None.
    """

    ts: Float[Array, "n L"]
    count: Int[Array, " L"]
    start: Bool[Array, "n L"]
    data: Float[Array, "n 2 L"]
    weight: Float[Array, "n 2 L"]
    prior: Float[Array, "n 4 L"]
    prior_weight: Float[Array, "n 4 L"]
    pieces: Float[Array, "n-1 4 L"] | None


class Linearised(NamedTuple):
    """Weighted residuals (model - data) of a block and their Jacobian.

    r: (L, n, 2); jac: (L, n, 2, c + d); prior_r: (L, n, 4); prior_jac: (L, n, 4, c + d);
    states: (L, n, c); complete: (L,); steps: (L,).
    """

    r: Float[Array, "L n 2"]
    jac: Float[Array, "L n 2 m"]
    prior_r: Float[Array, "L n 4"]
    prior_jac: Float[Array, "L n 4 m"]
    states: Float[Array, "L n c"]
    complete: Bool[Array, " L"]
    steps: Int[Array, " L"]


@functools.partial(jax.jit, static_argnums=(0, 1))
def linearise(
    layout: Layout,
    tolerances: Tolerances,
    p: Float[Array, "P L"],
    x0: Float[Array, "n c L"],
    block: Block,
    directions: Int[Array, " d"],
) -> Linearised:
    """Integrates a block of windows and returns its residuals and their derivatives.

    Args:
        layout: structure of the model; static.
        tolerances: of the integration; static.
        p: all slots for every lane.
        x0: states at the windows' starts.
        block: the data.
        directions: slots to differentiate by.
    """
    kind = (tolerances, block.pieces is None)
    TRACES.append((layout, p.shape, block.ts.shape, directions.shape, kind))
    slots = tuple(p)

    def motion(hooks):
        def field(t, y, q, piece, left):
            return layout.model(q, piece, left, hooks).derivative(t, y)

        return Motion(field, layout.depends(hooks))

    # The motion is integrated without the effects that are null and not differentiated by: those
    # of the sensors never matter to it, those of the contact and of the rest may or may not.
    groups = (CONTACT, COLUMN)
    motions = [motion(NONE), motion(CONTACT), motion(COLUMN), motion(CONTACT | COLUMN)]
    choice = sum(2**i * _active(layout, g, p, directions) for i, g in enumerate(groups))
    eps = (layout.index["eps1"], layout.index["eps2"])
    lanes = Lanes(block.ts, block.count, block.start, x0, block.pieces)
    run = integrate(motions, slots, lanes, eps, choice, directions, tolerances)
    y = tuple(jnp.moveaxis(run.y, 2, 0).transpose(0, 2, 1))  # components (n, L)
    if block.pieces is None:
        piece, left = None, None
    else:
        last = jnp.concatenate([block.pieces, block.pieces[-1:]])
        piece = tuple(last.transpose(1, 0, 2))
        left = jnp.concatenate([block.ts[:-1], block.ts[-2:-1]])
    wide = tuple(jnp.broadcast_to(q, block.ts.shape) for q in slots)

    # Readings and their rates in one go: the samples need the first two, the prior all four.
    def readings(t, y, q):
        model = layout.model(q, piece, left)
        f = lambda t, y: jnp.stack(model.readings(t, y))  # noqa: E731
        rates = model.derivative(t, y)
        h, dh = jax.jvp(f, (t, y), (jnp.ones_like(t), rates))
        return jnp.concatenate([h, dh])

    # What acts on the motion alone reaches the readings through the states only.
    depends = layout.depends(SENSORS)
    value, by_state, by_slot = _derivatives(readings, block.ts, y, wide, depends)
    s = run.s.transpose(2, 3, 1, 0)  # (c, m, n, L)
    jac = sum(by_state[k][:, None] * s[k][None] for k in range(len(y)))  # (4, m, n, L)
    nc = len(y)
    jac = jac.at[:, nc:].add(jnp.take(by_slot, directions, axis=1))
    weight = block.weight.transpose(1, 0, 2)
    prior_weight = block.prior_weight.transpose(1, 0, 2)
    r = (value[:2] - block.data.transpose(1, 0, 2)) * weight
    prior_r = (value - block.prior.transpose(1, 0, 2)) * prior_weight
    return Linearised(
        r=r.transpose(2, 1, 0),
        jac=(jac[:2] * weight[:, None]).transpose(3, 2, 0, 1),
        prior_r=prior_r.transpose(2, 1, 0),
        prior_jac=(jac * prior_weight[:, None]).transpose(3, 2, 0, 1),
        states=run.y,
        complete=run.complete & jnp.all(jnp.isfinite(r), axis=(0, 1)),
        steps=run.steps,
    )


def _active(layout: Layout, hooks: frozenset[str], p: Array, directions: Array) -> Array:
    """Whether any effect at these hooks has an amplitude or is differentiated by (0 or 1)."""
    mine = jnp.asarray(layout.amplitudes(hooks), int)
    active = jnp.any(p[mine] != 0.0) | jnp.any(jnp.isin(directions, mine))
    return active.astype(int)


def _derivatives(f, t, y, q, depends):
    """Value, derivatives by component and by slot of `f(t, y, q)`, one tangent at a time."""
    one = jnp.ones_like(t)
    value = f(t, y, q)
    by_state = [
        jax.jvp(lambda x, k=k: f(t, (*y[:k], x, *y[k + 1 :]), q), (y[k],), (one,))[1]
        for k in range(len(y))
    ]
    by_slot = [
        jax.jvp(lambda x, k=k: f(t, y, (*q[:k], x, *q[k + 1 :])), (q[k],), (one,))[1]
        if k in depends
        else jnp.zeros_like(value)
        for k in range(len(q))
    ]
    return value, by_state, jnp.stack(by_slot, axis=1)
