"""Whole runs, thousands at a time: the engine of sweeps, simulations and sensitivities.

Runs stand side by side in *lanes*, the last axis of every array. Each lane has its own time and
step; a lane that has finished its run takes the next one of the queue, so that a run that sticks
and crawls keeps one lane busy and no other waiting.

Two loops, one in the other. The inner one steps, and writes what falls between two steps into a
small buffer, row by row. The outer one sorts the rows into the result and hands out new runs.

Tangents are the exact derivatives of the steps taken, their sizes held fixed
(`tp_jax.simulation.tangents`).
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.control import Control, error_ratio, factor, layers, reversal_rate
from tp_jax.simulation.one_piece import in_one_piece, put_rows
from tp_jax.simulation.step import Field, Restart, Stepped, Structure, advance, between, structure
from tp_jax.simulation.tableau import RODAS4
from tp_jax.simulation.tangents import Curvature, curvature, differentiate, linear

PASSES = 64
"""Steps between two visits of the outer loop."""

OUTSIDE = 30.0
"""Velocities, in 1/eps, so far from zero are outside the layer of a smoothed sign."""

SLOWEST = 0.3
"""Natural frequency [rad/s] below which nothing pulls the column back in a time that matters."""

SMALLEST = 1e-13
"""A lane whose step [s] falls below this is given up."""


class Ran(NamedTuple):
    """States at the sample times.

    y: (N, n, 4) angles [rad] and velocities [rad/s], (N, n, 2) without velocities; s: (N, n, 4 or
    2, c + d) their derivatives by the components of the initial state and the directions, or
    None; steps: (N,) attempted; complete: (N,); error: (N, c + d) accumulated embedded error of
    the tangents of the angles, relative to the largest, or None.
    """

    y: Float[Array, "N n 4"]
    s: Float[Array, "N n 4 D"] | None
    steps: Int[Array, " N"]
    complete: Bool[Array, " N"]
    error: Float[Array, "N D"] | None


class _Lanes(NamedTuple):
    """State that the inner loop carries; lists of components (L,), tangents (D, L)."""

    t: Array
    k: Array  # next sample; n where the run is complete, n + 1 where it was given up
    h: Array
    steps: Array
    y: list[Array]
    f: list[Array]
    s: list[Array]
    fs: list[Array]
    doubt: Array  # (D, L) accumulated error of the angles' tangents
    unit: Array  # (D, L) ones, see `tangents.differentiate`
    jumps: tuple[Array, Array]  # see `sign_jumps`


def integrate(
    field: Field,
    p: tuple[Float[Array, " N"], ...],
    y0: Float[Array, "c N"],
    ts: Float[AnyArray, " n"],
    eps: tuple[Float[Array, " N"], Float[Array, " N"]],
    control: Control,
    *,
    directions: Int[Array, " d"] | None = None,
    width: int = 64,
    per_step: int = 2,
    velocities: bool = True,
    tangent_velocities: bool = True,
    max_steps: int | Array = 1_000_000,
    active: int | Array | None = None,
) -> Ran:
    """Integrates N runs over the same sample times.

    Args:
        field: derivatives of the state, elementwise over lanes.
        p: parameters, one value per run.
        y0: initial states.
        ts: sample times [s], increasing.
        eps: slopes of the smoothed signs of v1 and v2 [s].
        control: bounds of a step.
        directions: places in p to differentiate by, besides the initial state; None for no
            derivatives at all. Data, not structure.
        width: number of lanes; static.
        per_step: most samples that a step may cross; static.
        velocities: whether they are wanted in addition to the angles; static.
        tangent_velocities: whether their derivatives are; static.
        max_steps: a run that needs more attempts is given up.
        active: only the first so many runs; all if None. Data: an array may be longer than needed.
    """
    field = jax.jit(field)  # traced once, though it is differentiated by everything
    active = y0.shape[1] if active is None else active
    ts, y0 = jnp.asarray(ts), jnp.asarray(y0)
    n_runs, n = y0.shape[1], ts.size
    nc, n_p = y0.shape[0], len(p)
    nd = 0 if directions is None else nc + directions.size
    width = min(width, n_runs)
    table = jnp.stack([*p, *eps, *y0])  # (P + 2 + c, N)
    first = 1e-2 * (ts[1] - ts[0])
    wanted = 4 if velocities else 2
    changing = 4 if velocities and tangent_velocities else 2
    rows = wanted + changing * nd
    shape = structure(field, nc, n_p)
    bends = curvature(field, shape, n_p) if nd else None
    if nd:  # tangents have to see every layer
        control = control._replace(crossing=0.0)

    def load(run: Array) -> tuple[tuple, tuple, list[Array]]:
        mine = table[:, run]
        return tuple(mine[:n_p]), (mine[n_p], mine[n_p + 1]), list(mine[n_p + 2 :])

    def begin(run: Array) -> _Lanes:
        q, e, y = load(run)
        zero = jnp.zeros_like(y[0])
        t = zero + ts[0]
        start = lambda y, q: list(field(t, tuple(y), q))  # noqa: E731
        f = start(y, q)
        s: list[Array] = []
        fs: list[Array] = []
        if bends is not None:
            s = [jnp.broadcast_to(jnp.eye(nc, nd)[j, :, None], (nd, run.size)) for j in range(nc)]
            change = linear(
                lambda y, q: tuple(start(y, q)),
                y,
                q,
                shape.by_state,
                bends.field_by_parameter,
                directions,
            ).along(s, nc)
            fs = [jnp.zeros((nd, run.size)) if x is None else x for x in change]
        return _Lanes(
            t,
            jnp.ones_like(run),
            zero + first,
            jnp.zeros_like(run),
            y,
            f,
            s,
            fs,
            jnp.zeros((nd, run.size)),
            1.0 + 0.0 * fs[-1] if nd else zero,
            sign_jumps(field, t, y, q, e),
        )

    def inner(run: Array, lanes: _Lanes) -> tuple[_Lanes, Array, Array]:
        q, e, _ = load(run)

        def go_on(carry):
            i, lanes, _, _ = carry
            return (i < PASSES) & jnp.any(lanes.k < n)

        def one(carry):
            i, lanes, rows, places = carry
            lanes, found, place = _pass(
                field,
                shape,
                bends,
                lanes,
                q,
                e,
                directions,
                ts,
                control,
                per_step,
                velocities,
                changing == 4,
            )
            # One by one: stacked first, every element would ask which of them it comes from.
            for r in range(per_step):
                for j, value in enumerate(found[r]):
                    rows[j] = put(rows[j], value, i, r)
                places = put(places, place[r], i, r)
            return i + 1, lanes, rows, places

        rows = [jnp.zeros((PASSES, per_step, run.size))] * wanted
        rows += [jnp.zeros((PASSES, per_step, nd, run.size))] * (changing if nd else 0)
        places = jnp.full((PASSES, per_step, run.size), n)
        _, lanes, rows, places = jax.lax.while_loop(go_on, one, (0, lanes, rows, places))
        values = jnp.stack(rows[:wanted], axis=-1)
        if nd:
            tangents = jnp.stack([r.transpose(0, 1, 3, 2) for r in rows[wanted:]], axis=-2)
            tangents = tangents.reshape(*tangents.shape[:-2], changing * nd)
            values = jnp.concatenate([values, tangents], axis=-1)
        return lanes, values, places

    def outer(carry):
        following, run, lanes, y, at_end = carry
        lanes, values, places = inner(run, lanes)
        (y,) = put_rows((y,), run, places, (values,))
        over = (lanes.k < n) & (~(lanes.h >= SMALLEST) | (lanes.steps > max_steps))
        lanes = lanes._replace(k=jnp.where(over, n + 1, lanes.k))
        done = lanes.k >= n
        first = jnp.zeros_like(run)
        at_end = put_rows(at_end, run, first, (lanes.steps, lanes.doubt.T, lanes.k == n))
        turn = following + jnp.cumsum(done) - 1
        fresh = done & (turn < active)
        run = jnp.where(fresh, turn, run)
        new = begin(run)
        lanes = jax.tree.map(lambda a, b: jnp.where(fresh, a, b), new, lanes)
        return following + jnp.sum(fresh), run, lanes, y, at_end

    def unfinished(carry):
        return jnp.any(carry[2].k < n)

    def every() -> tuple:
        run = jnp.arange(width)
        lanes = begin(run)
        lanes = lanes._replace(k=jnp.where(run < active, lanes.k, n + 1))
        y = jnp.full((n_runs, n + 1, rows), jnp.inf)
        initial = jnp.zeros((n_runs, rows)).at[:, :wanted].set(y0[:wanted].T)
        if nd:
            initial = initial.at[:, wanted:].set(jnp.eye(changing, nd).reshape(-1))
        y = y.at[:, 0].set(initial)
        at_end = (
            jnp.zeros((n_runs, 1), int),
            jnp.zeros((n_runs, 1, nd)),
            jnp.zeros((n_runs, 1), bool),
        )
        carry = (jnp.array(width), run, lanes, y, at_end)
        return jax.lax.while_loop(unfinished, outer, carry)[3:]

    y, (steps, doubt, complete) = in_one_piece(every)
    steps, doubt, complete = steps[:, 0], doubt[:, 0], complete[:, 0]
    y = y[:, :n]
    if not nd:
        return Ran(y, None, steps, complete, None)
    s = y[..., wanted:].reshape(n_runs, n, changing, nd)
    largest = jnp.max(jnp.abs(s[:, :, :2]), axis=(1, 2))
    return Ran(y[..., :wanted], s, steps, complete, doubt / jnp.maximum(largest, 1e-300))


def _pass(
    field: Field,
    shape: Structure,
    bends: Curvature | None,
    lanes: _Lanes,
    q: tuple,
    e: tuple,
    directions: Array | None,
    ts: Array,
    c: Control,
    per_step: int,
    velocities: bool,
    tangent_velocities: bool,
) -> tuple[_Lanes, list[list[Array]], list[Array]]:
    """One attempt at a step in every lane, and what lies inside it."""
    n = ts.size
    t, k, y, f = lanes.t, lanes.k, lanes.y, lanes.f
    active = k < n
    # Cross no more samples than there are rows; land on the last one.
    beyond = jnp.minimum(k + per_step, n - 1)
    room = (ts[beyond] - t) * jnp.where(k + per_step < n, 1.0 - 1e-9, 1.0)
    room = jnp.where(active, room, 1.0)
    h, new, ratio = attempt(field, shape, t, lanes.h, room, y, f, q, e, c, jumps=lanes.jumps)
    accept = active & (ratio <= 1.0)
    rate = clock_rate(field, t, y, q)

    inside = [(ts[jnp.minimum(k + r, n - 1)] - t) / h for r in range(per_step)]

    rows = between(inside, h, y, f, new.y, new.f, rate, velocities)  # per sample, four components
    s, fs, doubt = lanes.s, lanes.fs, lanes.doubt
    if bends is not None:
        assert directions is not None
        s_end, f_end, wrong = differentiate(
            field,
            shape,
            bends,
            RODAS4,
            t,
            h,
            y,
            q,
            new.stages,
            s,
            fs,
            directions,
            lanes.unit,
        )
        # the interpolation is linear in what it joins
        tangents = between(inside, h, s, fs, s_end, f_end, rate, tangent_velocities)
        rows = [a + b for a, b in zip(rows, tangents, strict=True)]
        keep = lambda a, b: jnp.where(accept, a, b)  # noqa: E731
        s = [keep(a, b) for a, b in zip(s_end, s, strict=True)]
        fs = [keep(a, b) for a, b in zip(f_end, fs, strict=True)]
        doubt = doubt + jnp.where(accept, jnp.abs(wrong[0]) + jnp.abs(wrong[1]), 0.0)
    # A sample just on the step's end belongs to it.
    passed = [accept & (k + r < n) & reached(x, h, t) for r, x in enumerate(inside)]
    place = [jnp.where(m, k + r, n) for r, m in enumerate(passed)]
    after = _Lanes(
        t=jnp.where(accept, t + h, t),
        k=k + sum(passed),
        h=jnp.where(active, h * factor(ratio, c), 1.0),
        steps=lanes.steps + active,
        y=[jnp.where(accept, a, b) for a, b in zip(new.y, y, strict=True)],
        f=[jnp.where(accept, a, b) for a, b in zip(new.f, f, strict=True)],
        s=s,
        fs=fs,
        doubt=doubt,
        unit=lanes.unit,
        jumps=lanes.jumps,
    )
    return after, rows, place


def attempt(
    field: Field,
    shape: Structure,
    t: Array,
    h: Array,
    room: Array,
    y: list[Array],
    f: list[Array],
    q: tuple,
    e: tuple,
    c: Control,
    restart: Restart | None = None,
    jumps: tuple[Array, Array] | None = None,
) -> tuple[Array, Stepped, Array]:
    """A step of the size that the control wants, no longer than `room`.

    jumps: see `control.layers`; None: every layer is resolved.

    Returns:
        Its size [s], the step, and its error against what is allowed (`control.error_ratio`).
    """
    natural = jnp.ones_like(t) * natural_frequency(field, t, y, q)
    known = None if jumps is None else layers(f, jumps, natural, c)
    h = 1.0 / jnp.maximum(jnp.maximum(1.0 / h, 1.0 / room), reversal_rate(y, f, e, c, known))
    new = advance(field, shape, RODAS4, t, h, y, f, q, restart)
    return h, new, error_ratio(y, new.y, new.error, e, natural, c, h, known)


def reached(x: Array, h: Array, t: Array) -> Array:
    """True where a step of size h from t comes to the sample x steps away, but for rounding."""
    return x <= 1.0 + 1e-9 + 4e-16 * jnp.maximum(jnp.abs(t), h) / h


def put(rows: Array, value: Array, i: Array, r: int) -> Array:
    """`rows` with `value` at (i, r)."""
    place = (i, r, *[0] * value.ndim)
    return jax.lax.dynamic_update_slice(rows, value[None, None], place)


def natural_frequency(field: Field, t: Array, y: list[Array], q: tuple) -> Array:
    """Natural frequency of the column [rad/s], from the spring's pull at this instant.

    Where nothing pulls, in a spring's play or without a spring, `SLOWEST`: an error of a velocity
    does no harm there for ever, and a bound of next to nothing could not be kept.
    """
    pull = jax.jvp(lambda x: field(t, (x, *y[1:]), q)[2], (y[0],), (jnp.ones_like(t),))[1]
    return jnp.sqrt(jnp.maximum(jnp.abs(pull), SLOWEST**2))


def sign_jumps(
    field: Field, t: Array, y: list[Array], q: tuple, eps: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Computes the greatest change of accelerations with the sign of either velocity [rad/s²].

    It changes with the motion only where an effect's friction does, and then by some part of
    itself: good enough for the control of steps, of which a run's beginning decides once.
    """
    found = []
    for i, e in zip((2, 3), eps, strict=True):
        beyond = OUTSIDE / e
        ends = [
            field(t, tuple(v if j == i else x for j, x in enumerate(y)), q)
            for v in (beyond, -beyond)
        ]
        found.append(
            jnp.maximum(jnp.abs(ends[0][2] - ends[1][2]), jnp.abs(ends[0][3] - ends[1][3]))
        )
    return found[0], found[1]


def clock_rate(field: Field, t: Array, y: list[Array], q: tuple) -> Array:
    """True seconds per recorded second: how fast an angle follows its velocity."""
    return jax.jvp(lambda x: field(t, (*y[:2], x, *y[3:]), q)[0], (y[2],), (jnp.ones_like(t),))[1]
