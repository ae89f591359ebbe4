"""The compiled programs: residuals of a block of windows and their Jacobian.

Four integrate: they differ in the effects that the motion carries (`groups`), since most of a
step's cost, and most of what is compiled, is effects. One makes readings of what they return. Which
numbers an effect has, and what is differentiated by, is data.
"""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from tp_jax.estimation.layout import Layout
from tp_jax.simulation.lanes import Integrated, Lanes, Tolerances, integrate

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


def groups(layout: Layout, p: np.ndarray, directions: Sequence[int]) -> frozenset[str]:
    """Hooks whose effects the motion needs: some have an amplitude or are differentiated by.

    Args:
        layout: structure of the model. p: (P, ...) its numbers. directions: slots.
    """
    hooks = NONE
    for group in (CONTACT, COLUMN):
        mine = list(layout.amplitudes(group))
        if np.any(p[mine]) or not set(directions).isdisjoint(mine):
            hooks |= group
    return hooks


def linearise(
    layout: Layout,
    tolerances: Tolerances,
    hooks: frozenset[str],
    p: Float[Array, "P L"],
    x0: Float[Array, "n c L"],
    block: Block,
    directions: Int[Array, " d"],
) -> Linearised:
    """Integrates a block of windows and returns its residuals and their derivatives.

    Args:
        layout: structure of the model; static.
        tolerances: of the integration; static.
        hooks: of the effects that act on the motion, from `groups`; static.
        p: all slots for every lane.
        x0: states at the windows' starts.
        block: the data.
        directions: slots to differentiate by.
    """
    run = _integrate(layout, tolerances, hooks, p, x0, block, directions)
    return _observe(layout, p, block, directions, run)


@functools.partial(jax.jit, static_argnums=(0, 1, 2))
def _integrate(layout, tolerances, hooks, p, x0, block, directions) -> Integrated:
    """States and tangents of a block's windows."""
    kind = (tolerances, block.pieces is None)
    TRACES.append((layout, hooks, p.shape, block.ts.shape, directions.shape, kind))

    def field(t, y, q, piece, left):
        return layout.model(q, piece, left, hooks).derivative(t, y)

    eps = (layout.index["eps1"], layout.index["eps2"])
    lanes = Lanes(block.ts, block.count, block.start, x0, block.pieces)
    return integrate(field, tuple(p), lanes, eps, directions, layout.estimable, tolerances)


@functools.partial(jax.jit, static_argnums=0)
def _observe(layout, p, block, directions, run) -> Linearised:
    """Readings of integrated windows, less the data."""
    slots = tuple(p)
    y = tuple(jnp.moveaxis(run.y, 2, 0).transpose(0, 2, 1))  # components (n, L)
    if block.pieces is None:
        piece, left = None, None
    else:
        last = jnp.concatenate([block.pieces, block.pieces[-1:]])
        piece = tuple(last.transpose(1, 0, 2))
        left = jnp.concatenate([block.ts[:-1], block.ts[-2:-1]])
    wide = tuple(jnp.broadcast_to(q, block.ts.shape) for q in slots)

    # Readings and their rates in one go: the samples need the first two, the prior all four. What
    # an effect of the motion does is in the states; the accelerations, of which a sensor's delay
    # takes the square of the delay, are those of the pendulum without.
    @jax.jit
    def readings(t, y, q):
        model = layout.model(q, piece, left, SENSORS)
        f = lambda t, y: jnp.stack(model.readings(t, y))  # noqa: E731
        rates = model.derivative(t, y)
        h, dh = jax.jvp(f, (t, y), (jnp.ones_like(t), rates))
        return jnp.concatenate([h, dh])

    # What acts on the motion alone reaches the readings through the states only.
    depends = set(layout.depends(SENSORS)) & set(layout.estimable)
    value, by_state, by_slot = _derivatives(readings, block.ts, y, wide, depends)
    s = run.s.transpose(2, 3, 1, 0)  # (c, m, n, L)
    # The sensors see angles and velocities, not the effects' own states.
    jac = sum(by_state[k][:, None] * s[k][None] for k in range(4))  # (4, m, n, L)
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


def _derivatives(f, t, y, q, depends):
    """Value, derivatives by component and by slot of `f(t, y, q)`, one tangent at a time."""
    one = jnp.ones_like(t)
    value = f(t, y, q)
    by_state = [
        jax.jvp(lambda x, k=k: f(t, (*y[:k], x, *y[k + 1 :]), q), (y[k],), (one,))[1]
        for k in range(4)
    ]
    by_slot = [
        jax.jvp(lambda x, k=k: f(t, y, (*q[:k], x, *q[k + 1 :])), (q[k],), (one,))[1]
        if k in depends
        else jnp.zeros_like(value)
        for k in range(len(q))
    ]
    return value, by_state, jnp.stack(by_slot, axis=1)
