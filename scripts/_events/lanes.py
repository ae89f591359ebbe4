"""Many runs with hard friction side by side, from event to event; the loops are the engine's.

A pass takes a step in every lane: as far as the series holds to the tolerance, up to the next
event, or over `PER_STEP` samples, whichever comes first. No step is refused. At an event the state
goes on with other signs; a derivative jumps by the change of the accelerations times the
derivative of the event's time (saltation). A body that is torn loose does not jump: its
acceleration begins at zero.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from scripts._bench.problem import DIRECTIONS, NAMES, VARIED
from tp_jax._compiler import compiler_options
from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.batch import in_pieces
from tp_jax.simulation.one_piece import in_one_piece, put_rows
from tp_jax.simulation.runs import PASSES, put

from .pieces import Series, series, settled, tangents, until_event, value, with_slope

ORDER = 10
"""Of the series."""

PER_STEP = 6
"""Samples that a step may cross."""

MOST = 100_000
"""A run that takes more steps is given up."""

ANGLE = 0.5
"""The longest step, as an angle of the drive [rad]: no body comes and goes unseen within half."""

UNSEEN = 30.0
"""Exponent from which on `exp(-T0 |v2|)` is too small to matter."""

D = len(DIRECTIONS)


class Found(NamedTuple):
    """angles: (N, n, 2) [rad]; derivatives: (N, n, 2, 14) in the order of `DIRECTIONS`, or None;
    steps, events: (N,); complete: (N,)."""

    angles: Float[np.ndarray, "N n 2"]
    derivatives: Float[np.ndarray, "N n 2 D"] | None
    steps: Int[np.ndarray, " N"]
    events: Int[np.ndarray, " N"]
    complete: Bool[np.ndarray, " N"]


def run(
    table: Float[AnyArray, "N P"],
    ts: Float[AnyArray, " n"],
    tolerance: float,
    y0: Float[AnyArray, "N 4"] | None = None,
    *,
    derivatives: bool = False,
    width: int = 0,
    per_step: int = PER_STEP,
) -> Found:
    """Runs of the rows of `table` (in the order of `NAMES`), on one thread.

    Args:
        table: parameters. ts: sample times [s]. tolerance: error of an angle in a step [rad].
        y0: initial states; rest if None.
        derivatives: whether they are wanted.
        width: lanes side by side; as many as are fastest if 0.
        per_step: samples that a step may cross.
    """
    many = len(table)
    starts = np.zeros((many, 4)) if y0 is None else np.asarray(y0)
    width = min(width or (16 if derivatives else 64), many)
    rows = 2 + (2 * D if derivatives else 0)
    out = np.empty((many, ts.size, rows)), *(np.empty(many, kind) for kind in (int, int, bool))

    def piece(index: np.ndarray, active: int) -> None:
        done = _compiled()(
            np.asarray(table).T[:, index],
            starts.T[:, index],
            ts,
            tolerance,
            np.asarray(active),
            derivatives,
            width,
            per_step,
        )
        for whole, its in zip(out, done, strict=True):
            whole[index[:active]] = np.asarray(its)[:active]

    in_pieces(piece, many, width=width, bytes_each=out[0][0].nbytes, threads=1)
    y, *counts = out
    s = y[..., 2:].reshape(many, ts.size, 2, D) if derivatives else None
    return Found(y[..., :2], s, *counts)


class _Lanes(NamedTuple):
    """What the loop carries. before: for the jump of the derivatives, accelerations just before
    an event, and of which body the velocity was zero there (0 none)."""

    t: Array
    k: Array  # next sample; n where the run is complete, n + 1 where it was given up
    steps: Array
    events: Array
    y: list[Array]
    signs: list[Array]
    tangents: list[Array]
    before: list[Array]
    one: Array  # (L,) and (D, L) ones, see `pieces`
    unit: Array


def _begin(run: Array, table: Array, start: Array, derivatives: bool) -> _Lanes:
    q, y = tuple(table[: len(NAMES), run]), list(table[len(NAMES) :, run])
    t = jnp.zeros_like(y[0]) + start
    no = jnp.zeros_like(run, bool)
    signs = settled(t, y, jnp.sign(y[2]), jnp.sign(y[3]), no, no, q)
    one = 1.0 + 0.0 * jnp.exp(-jnp.abs(y[2]))
    s, before = [], []
    if derivatives:
        s = [jnp.broadcast_to(row[:, None], (D, run.size)) for row in jnp.eye(4, D, len(VARIED))]
        before = [0.0 * t, 0.0 * t, 0 * run]
    unit = one * jnp.ones((D if derivatives else 1, 1))
    return _Lanes(t, 1 + 0 * run, 0 * run, 0 * run, y, list(signs), s, before, one, unit)


def _length(p: list[Series], natural: Array, tolerance: Array) -> Array:
    """Step [s] whose last two terms are within the tolerance; velocities by a natural frequency."""
    q1, q2, v1, v2 = p
    rates = []
    for m in (ORDER - 1, ORDER):
        angle = jnp.maximum(jnp.abs(q1[m]), jnp.abs(q2[m]))
        velocity = jnp.maximum(jnp.abs(v1[m]), jnp.abs(v2[m])) / natural
        size = jnp.maximum(jnp.maximum(angle, velocity), 1e-200)
        rates.append(jnp.log(size / tolerance) * (1.0 / m))
    return jnp.exp(-jnp.maximum(*rates))


def _first_event(bodies: tuple[Series, Series], h: Array, one: Array) -> tuple[Array, Array]:
    """Time (2, L) of each body's event within the step h, and whether there is one.

    Newton's method within a bracket. The loop is one so that XLA holds the coefficients in memory.
    """
    c = jnp.stack([jnp.stack([a / one, b / one]) for a, b in zip(*bodies, strict=True)])
    half, end = value(c, 0.5 * h), value(c, h)
    happens = (half <= 0.0) | (end <= 0.0)
    high = jnp.where(half <= 0.0, 0.5 * h, h)

    def go_on(carry):
        i, _, _, _, moved = carry
        return (i < 60) & jnp.any(moved)

    def closer(carry):
        i, x, low, high, _ = carry
        height, slope = with_slope(c, x)
        low, high = jnp.where(height > 0.0, x, low), jnp.where(height > 0.0, high, x)
        new = x - height / jnp.where(slope == 0.0, 1.0, slope)
        new = jnp.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        return i + 1, new, low, high, happens & (jnp.abs(new - x) > 1e-13)

    _, x, *_ = jax.lax.while_loop(go_on, closer, (0, high, 0.0 * high, high, happens))
    return x, happens


def _pass(
    lanes: _Lanes, q: tuple, ts: Array, tolerance: Array, derivatives: bool, per_step: int
) -> tuple[_Lanes, list[list[Array]], list[Array]]:
    """A step in every lane, and the samples inside it."""
    t, k, y, one, n = lanes.t, lanes.k, lanes.y, lanes.one, ts.size
    s1, s2 = lanes.signs
    active = k < n
    p = series(t, y, s1, s2, q, ORDER, one)
    states = [p.q1, p.q2, p.v1, p.v2]
    room = jnp.where(k + per_step < n, 1.0 - 1e-9, 1.0) * (ts[jnp.minimum(k + per_step, n - 1)] - t)
    h = jnp.minimum(_length(states, jnp.sqrt(q[0] / q[2]), tolerance), ANGLE / q[10])
    # where the rider slows down, exp(-T0 |v2|) grows: no series sees it come from far below
    growing = q[9] * jnp.maximum(-s2 * p.a2[0], 0.0)
    h = jnp.minimum(h, jnp.maximum(0.5 * ORDER, q[9] * jnp.abs(y[3]) - UNSEEN) / growing)
    h = jnp.minimum(h, jnp.where(active, room, 1.0)) / one

    sign = jnp.where(value(p.needed, h) / one < 0.0, -1.0, 1.0)
    x, happens = _first_event(until_event(p, s1, s2, q, sign), h, one)
    x = jnp.where(happens, x, 2.0 * h)
    hit = happens[0] | happens[1]
    hits = hit & (x[0] <= x[1]), hit & (x[0] > x[1])
    x = jnp.minimum(jnp.minimum(x[0], x[1]), h)
    zero1, zero2 = hits[0] & (s1 != 0.0), hits[1] & (s2 != 0.0)
    end = [value(c, x) / one for c in states]
    end[2] = jnp.where(zero1 | (s1 == 0.0), 0.0, end[2])
    end[3] = jnp.where(zero2 | (s2 == 0.0), 0.0, end[3])
    after = settled(t + x, end, s1, s2, hits[0] & ~zero1, hits[1] & ~zero2, q)
    signs = [jnp.where(hit, a, b) / one for a, b in zip(after, (s1, s2), strict=True)]

    inside = [ts[jnp.minimum(k + r, n - 1)] - t for r in range(per_step)]
    rows = [[value(p.q1, z), value(p.q2, z)] for z in inside]
    s, before = lanes.tangents, lanes.before
    if derivatives:
        a1, a2, body = before
        own = jnp.where(body == 1, a1, a2)
        when = -jnp.where(body == 1, s[2], s[3]) / jnp.where(own == 0.0, 1.0, own)
        when = jnp.where(body == 0, 0.0, when)
        start = [s[0], s[1]]
        for change, its, sg in ((a1 - p.a1[0], s[2], s1), (a2 - p.a2[0], s[3], s2)):
            start.append(jnp.where(sg == 0.0, 0.0, its + change * when) / lanes.unit)
        found = tangents(start, p, s1, s2, q, ORDER, one, lanes.unit)
        for row, z in zip(rows, inside, strict=True):
            row += [value(found[0], z), value(found[1], z)]
        s = [jnp.where(active, value(c, x), old) for c, old in zip(found, s, strict=True)]
        before = [value(p.a1, x) / one, value(p.a2, x) / one, jnp.where(zero1, 1, 2 * zero2)]

    reach = jnp.where(hit, x, h * (1.0 + 1e-9) + 4e-16 * jnp.maximum(jnp.abs(t), h))
    passed = [active & (k + r < n) & (z <= reach) for r, z in enumerate(inside)]
    keep = lambda a, b: jnp.where(active, a, b)  # noqa: E731
    new = _Lanes(
        keep(t + x, t),
        k + sum(passed),
        lanes.steps + active,
        lanes.events + (active & hit),
        [keep(a, b) for a, b in zip(end, y, strict=True)],
        [keep(a, b) for a, b in zip(signs, (s1, s2), strict=True)],
        s,
        before,
        one,
        lanes.unit,
    )
    return new, rows, [jnp.where(m, k + r, n) for r, m in enumerate(passed)]


@functools.cache
def _compiled():
    return jax.jit(_run, static_argnums=(5, 6, 7), compiler_options=compiler_options())


def _run(p, y0, ts, tolerance, active, derivatives: bool, width: int, per_step: int):
    """As `tp_jax.simulation.runs.integrate`: lanes that take the next run of a queue."""
    many, n = y0.shape[1], ts.size
    table = jnp.concatenate([p, y0])
    size = 2 + (2 * D if derivatives else 0)

    def inner(run: Array, lanes: _Lanes):
        q = tuple(table[: len(NAMES), run])

        def one(carry):
            i, lanes, rows, places = carry
            lanes, found, place = _pass(lanes, q, ts, tolerance, derivatives, per_step)
            for r in range(per_step):
                rows = [put(row, x, i, r) for row, x in zip(rows, found[r], strict=True)]
                places = put(places, place[r], i, r)
            return i + 1, lanes, rows, places

        rows = [jnp.zeros((PASSES, per_step, run.size))] * 2
        rows += [jnp.zeros((PASSES, per_step, D, run.size))] * 2 * derivatives
        places = jnp.full((PASSES, per_step, run.size), n)
        go_on = lambda carry: (carry[0] < PASSES) & jnp.any(carry[1].k < n)  # noqa: E731
        _, lanes, rows, places = jax.lax.while_loop(go_on, one, (0, lanes, rows, places))
        values = jnp.stack(rows[:2], axis=-1)
        if derivatives:
            s = jnp.stack([row.transpose(0, 1, 3, 2) for row in rows[2:]], axis=-2)
            values = jnp.concatenate([values, s.reshape(*s.shape[:-2], 2 * D)], axis=-1)
        return lanes, values, places

    def outer(carry):
        following, run, lanes, y, ends = carry
        lanes, values, places = inner(run, lanes)
        (y,) = put_rows((y,), run, places, (values,))
        given_up = (lanes.k < n) & (lanes.steps > MOST)
        lanes = lanes._replace(k=jnp.where(given_up, n + 1, lanes.k))
        of_run = lanes.steps, lanes.events, lanes.k == n
        ends = put_rows(ends, run, jnp.zeros_like(run), of_run)
        done = lanes.k >= n
        turn = following + jnp.cumsum(done) - 1
        fresh = done & (turn < active)
        run = jnp.where(fresh, turn, run)
        new = _begin(run, table, ts[0], derivatives)
        lanes = jax.tree.map(lambda a, b: jnp.where(fresh, a, b), new, lanes)
        return following + jnp.sum(fresh), run, lanes, y, ends

    def every():
        run = jnp.arange(width)
        lanes = _begin(run, table, ts[0], derivatives)
        lanes = lanes._replace(k=jnp.where(run < active, lanes.k, n + 1))
        y = jnp.full((many, n + 1, size), jnp.inf)
        y = y.at[:, 0, 2:].set(jnp.eye(2, D, len(VARIED)).reshape(-1) if derivatives else 0.0)
        y = y.at[:, 0, :2].set(y0[:2].T)
        ends = tuple(jnp.zeros((many, 1), kind) for kind in (int, int, bool))
        carry = (jnp.array(width), run, lanes, y, ends)
        return jax.lax.while_loop(lambda c: jnp.any(c[2].k < n), outer, carry)[3:]

    y, ends = in_one_piece(every)
    return y[:, :n], *(x[:, 0] for x in ends)
