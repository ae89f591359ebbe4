"""Many short runs at once, with tangents: the engine under all estimation.

Every run (a window of a recording, at some parameters) is part of a *lane*: the last axis of every
array. A lane takes its windows one after the other and has its own time and step; none waits for
another. Steps, tangents and what lies between samples are those of whole runs
(`tp_jax.simulation.runs`): what differs is that every lane has its own sample times, that a new
window begins somewhere in their middle, and that a drive may have been measured, so that the field
has another piece of its curve between any two samples.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from tp_jax.simulation.control import Control, factor
from tp_jax.simulation.one_piece import in_one_piece, put_rows
from tp_jax.simulation.runs import PASSES, SMALLEST, attempt, clock_rate, put, reached
from tp_jax.simulation.step import Restart, between, structure
from tp_jax.simulation.tableau import RODAS4
from tp_jax.simulation.tangents import Curvature, curvature, differentiate, initial

#: field(t, y, p, piece, left) -> derivatives of y; y and p are tuples of arrays (L,), piece the
#: four coefficients of a measured drive from the time `left` on, both None where there is none.
Field = Callable[..., tuple]


class Tolerances(NamedTuple):
    """Error of an angle in a step [rad], and of the friction within one (`Control.friction`)."""

    angle: Array | float = 1e-6
    friction: Array | float = 0.2


class Lanes(NamedTuple):
    """Windows in lanes, as the engine integrates them.

    A lane takes several windows one after the other, so that all lanes are busy whatever the
    windows' length: at a sample marked as a start the state is set anew, not integrated.

    ts: (n, L) sample times [s], the last repeated where a lane has fewer; count: (L,) number of
    samples; start: (n, L) whether a window starts there; states: (n, c, L) state at each start;
    pieces: (n - 1, 4, L) cubic coefficients of a measured drive, or None.
    """

    ts: Float[Array, "n L"]
    count: Int[Array, " L"]
    start: Bool[Array, "n L"]
    states: Float[Array, "n c L"]
    pieces: Float[Array, "n-1 4 L"] | None


class Integrated(NamedTuple):
    """States and tangents at the samples, lanes first.

    y: (L, n, c) components; s: (L, n, 4, c + d) derivatives of angles and velocities with respect
    to the components at the window's start and the chosen directions; steps: (L,) attempted;
    complete: (L,) False where the lane was given up; taken: (L, n) steps until each sample.
    """

    y: Float[Array, "L n c"]
    s: Float[Array, "L n 4 m"]
    steps: Int[Array, " L"]
    complete: Bool[Array, " L"]
    taken: Int[Array, "L n"]


class _State(NamedTuple):
    """State that the inner loop carries; lists of components (L,), tangents (D, L)."""

    t: Array
    k: Array  # next sample
    h: Array
    steps: Array
    y: list[Array]
    f: list[Array]
    s: list[Array]
    fs: list[Array]


def integrate(
    motion: Field,
    p: tuple[Float[Array, " L"], ...],
    lanes: Lanes,
    eps: tuple[int, int],
    directions: Int[Array, " d"],
    among: Sequence[int],
    tolerances: Tolerances = Tolerances(),  # noqa: B008
    max_steps: int | Array = 20_000,
) -> Integrated:
    """Integrates all lanes over their samples.

    Args:
        motion: derivatives of the state, elementwise over lanes.
        p: every parameter of the model, one value per lane.
        lanes: sample times and window starts.
        eps: places in `p` of the two smoothing slopes.
        directions: places in `p` of the parameters to differentiate by; data, not structure.
        among: all places that may ever be asked for; structure. Others count as zero.
        tolerances: see `Tolerances`.
        max_steps: a lane that needs more attempts, eight for each sample set aside, is given up.
    """
    y0 = lanes.states[0]
    n = lanes.ts.shape[0]
    nc, width = y0.shape
    nd = nc + directions.size
    lane = jnp.arange(width)
    n_p = len(p)
    measured = lanes.pieces is not None
    # More than a sample in a step would be more than a piece of the drive.
    per_step = 1 if measured else 2

    @jax.jit  # traced once, though it is differentiated by everything
    def field(t, y, q):
        piece, left = (q[n_p : n_p + 4], q[n_p + 4]) if measured else (None, None)
        return motion(t, y, q[:n_p], piece, left)

    def arguments(i: Array) -> tuple:
        """Parameters and the piece of the drive from sample i on."""
        if lanes.pieces is None:
            return p
        i = jnp.clip(i, 0, n - 2)
        return (*p, *lanes.pieces[i, :, lane].T, lanes.ts[i, lane])

    more = 5 if measured else 0
    shape = structure(field, nc, n_p + more)
    bends = curvature(field, shape, n_p + more)
    asked = np.zeros(n_p + more, bool)
    asked[list(among)] = True
    by_parameter, of_field = bends.by_parameter & asked, bends.field_by_parameter & asked
    bends = Curvature(bends.entries, bends.by_state, by_parameter, of_field)
    # A lane begins with a window.
    start = lanes.start.at[0].set(True)
    control = Control(angle=tolerances.angle, friction=tolerances.friction)
    slopes = (p[eps[0]], p[eps[1]])
    # Last sample of the window that each sample belongs to.
    row = jnp.arange(n)[:, None]
    begins = jnp.where(start | (row >= lanes.count), row, n)
    following = jax.lax.cummin(jnp.concatenate([begins[1:], jnp.full((1, width), n)]), reverse=True)
    final = jnp.minimum(following, lanes.count) - 1
    # The smallest step between samples, since a window may be a single one.
    apart = jnp.diff(lanes.ts, axis=0)
    first = 1e-2 * jnp.min(jnp.where(apart > 0.0, apart, 1.0), axis=0)
    # last digits are those of a lane's other windows, whose times they come from
    first = first.astype(jnp.float32).astype(y0.dtype)
    # the tangents' shape, ones that the compiler does not know to be ones
    unit = 1.0 + 0.0 * jnp.broadcast_to(p[0], (nd, width))

    def at(table: Array, i: Array) -> Array:
        return table[jnp.minimum(i, n - 1), lane]

    def one_pass(state: _State) -> tuple[_State, list[list[Array]], list[Array]]:
        t, k, y, f = state.t, state.k, state.y, state.f
        active = k < lanes.count
        fresh = active & at(start, k)
        going = active & ~fresh
        last = at(final, k)
        if measured:
            room = at(lanes.ts, k) - t
        else:
            # Cross no more samples than there are rows; land on the last one.
            beyond = k + per_step
            room = at(lanes.ts, jnp.minimum(beyond, last)) - t
            room = room * jnp.where(beyond <= last, 1.0 - 1e-9, 1.0)
        room = jnp.where(going, room, 1.0)
        q = arguments(k - 1)
        beginning = list(lanes.states[jnp.minimum(k, n - 1), :, lane].T)
        restart = Restart(fresh, at(lanes.ts, k), beginning, arguments(k))
        h, new, ratio = attempt(field, shape, t, state.h, room, y, f, q, slopes, control, restart)
        accept = going & (ratio <= 1.0)
        rate = clock_rate(field, t, y, q)
        inside = [(at(lanes.ts, k + r) - t) / h for r in range(per_step)]
        rows = between(inside, h, y, f, new.y, new.f, rate, True)
        s_end, f_end, _ = differentiate(
            field,
            shape,
            bends,
            RODAS4,
            t,
            h,
            y,
            q,
            new.stages,
            state.s,
            state.fs,
            directions,
            unit,
            restart,
        )
        tangents = between(inside, h, state.s, state.fs, s_end, f_end, rate, True)
        begun = initial(nc, unit)
        found = []
        for r in range(per_step):
            own = [y[j] + inside[r] * (new.y[j] - y[j]) for j in range(4, nc)]
            values = [*rows[r], *own]
            if r == 0:
                values = [jnp.where(fresh, a, b) for a, b in zip(beginning, values, strict=True)]
            found.append(
                values + [jnp.where(fresh, a, b) for a, b in zip(begun, tangents[r], strict=False)]
            )
        # A sample just on the step's end belongs to it.
        passed = [
            (accept & (k + r <= last) & reached(x, h, t)) | (fresh if r == 0 else False)
            for r, x in enumerate(inside)
        ]
        place = [jnp.where(m, k + r, n) for r, m in enumerate(passed)]
        size = jnp.where(going, h * factor(ratio, control), jnp.where(fresh, first, 1.0))

        def choose(go, begin, stay):
            return [
                jnp.where(fresh, b, jnp.where(accept, a, c))
                for a, b, c in zip(go, begin, stay, strict=True)
            ]

        after = _State(
            t=jnp.where(fresh, restart.t, jnp.where(accept, t + h, t)),
            k=k + sum(passed),
            h=size,
            steps=state.steps + active,
            y=choose(new.y, beginning, y),
            f=choose(new.f, new.f, f),
            s=choose(s_end, begun, state.s),
            fs=choose(f_end, f_end, state.fs),
        )
        return after, found, place

    def inner(state: _State) -> tuple[_State, Array, Array, Array]:
        def go_on(carry):
            return (carry[0] < PASSES) & jnp.any(carry[1].k < lanes.count)

        def one(carry):
            i, state, rows, places = carry
            state, found, place = one_pass(state)
            for r in range(per_step):
                for j, value in enumerate(found[r]):
                    rows[j] = put(rows[j], value, i, r)
                places = put(places, place[r], i, r)
            return i + 1, state, rows, places

        rows = [jnp.zeros((PASSES, per_step, width))] * nc
        rows += [jnp.zeros((PASSES, per_step, nd, width))] * 4
        places = jnp.full((PASSES, per_step, width), n)
        _, state, rows, places = jax.lax.while_loop(go_on, one, (0, state, rows, places))
        tangents = jnp.stack([r.transpose(0, 1, 3, 2) for r in rows[nc:]], axis=-2)
        return state, jnp.stack(rows[:nc], axis=-1), tangents, places

    def outer(carry):
        i, state, y, s, taken = carry
        state, values, tangents, places = inner(state)
        # A lane steps in every pass until it is done, so that a row's place says how often it did.
        passes = jnp.broadcast_to(PASSES * i + jnp.arange(PASSES)[:, None, None], places.shape)
        y, s, taken = put_rows((y, s, taken), lane, places, (values, tangents, passes))
        limit = max_steps + 8 * lanes.count
        over = (state.k < lanes.count) & (~(state.h >= SMALLEST) | (state.steps > limit))
        return i + 1, state._replace(k=jnp.where(over, n + 1, state.k)), y, s, taken

    def run():
        zero = jnp.zeros(width)
        none = [0.0 * unit] * nc
        state = _State(
            lanes.ts[0],
            jnp.zeros(width, int),
            zero + first,
            jnp.zeros(width, int),
            list(y0),
            [zero] * nc,
            none,
            none,
        )
        y, s = jnp.zeros((width, n + 1, nc)), jnp.zeros((width, n + 1, 4, nd))
        carry = (0, state, y, s, jnp.zeros((width, n + 1), int))
        return jax.lax.while_loop(lambda c: jnp.any(c[1].k < lanes.count), outer, carry)

    _, state, y, s, taken = in_one_piece(run)
    complete = state.k == lanes.count
    return Integrated(y[:, :n], s[:, :n], state.steps, complete, taken[:, :n])
