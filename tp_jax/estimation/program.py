"""The compiled programs: residuals of a block of windows and their Jacobian.

Those that integrate differ in the effects that the motion carries (`program_choice`): most of a
step's cost, and most of what is compiled, is effects. One makes readings of what they return. Which
numbers an effect has, and what is differentiated by, is data.
"""

import dataclasses
import functools
import hashlib
import logging
from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import export
from jaxtyping import Array, Bool, Float, Int

from tp_jax._stored import Stored
from tp_jax.estimation.layout import Layout
from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.columns import columns, some_columns
from tp_jax.simulation.lanes import Integrated, Lanes, Tolerances, integrate

log = logging.getLogger(__name__)

TRACES: list[tuple] = []  # one entry per trace; tests count them


class Block(NamedTuple):
    """Data of a block of windows (lanes last; a lane holds several windows, see `Lanes`).

    ts: (n, L) s; count: (L,); start: (n, L); data: (n, 2, L) rad; weight: (n, 2, L), 1/sigma, 0
    where there is no sample; begins: (W, L) first samples of a lane's windows, one after the other;
    prior: (W, 4, L) smoothed readings and their rates there; prior_weight: (W, 4, L), 0 where there
    is no window; pieces: (n - 1, 4, L) or None.
    """

    ts: Float[AnyArray, "n L"]
    count: Int[AnyArray, " L"]
    start: Bool[AnyArray, "n L"]
    data: Float[AnyArray, "n 2 L"]
    weight: Float[AnyArray, "n 2 L"]
    begins: Int[AnyArray, "W L"]
    prior: Float[AnyArray, "W 4 L"]
    prior_weight: Float[AnyArray, "W 4 L"]
    pieces: Float[AnyArray, "n-1 4 L"] | None


class Linearised(NamedTuple):
    """Weighted residuals (model - data) of a block and their Jacobian.

    r: (L, n, 2); jac: (L, n, 2, 4 + d); prior_r: (L, W, 4); prior_jac: (L, W, 4, 4 + d);
    states: (L, n, 4); complete: (L,); taken: (L, n) steps until each sample; own: (L, n, k) the
    effects' own states, by which nothing is differentiated.
    """

    r: Float[AnyArray, "L n 2"]
    jac: Float[AnyArray, "L n 2 m"]
    prior_r: Float[AnyArray, "L W 4"]
    prior_jac: Float[AnyArray, "L W 4 m"]
    states: Float[AnyArray, "L n 4"]
    complete: Bool[AnyArray, " L"]
    taken: Int[AnyArray, "L n"]
    own: Float[AnyArray, "L n k"] | None = None


for _kind in (Block, Linearised, Integrated):
    export.register_namedtuple_serialization(_kind, serialized_name=f"tp_jax.{_kind.__name__}")


def linearise(
    layout: Layout,
    tolerances: Tolerances | Float[AnyArray, " 2"],
    ids: frozenset[str],
    p: Float[AnyArray, "P L"],
    x0: Float[AnyArray, "n c L"],
    block: Block,
    directions: Int[AnyArray, " d"],
) -> Linearised:
    """Integrates a block of windows and returns its residuals and their derivatives.

    Args:
        layout: structure of the model; static.
        tolerances: of the integration, or an array of them; data, so that finer ones compile
            nothing.
        ids: effects of the motion that it carries, from `program_choice.Programs`; static.
        p: all slots for every lane.
        x0: states at the windows' starts.
        block: the data.
        directions: slots to differentiate by.
    """
    steps = np.array(tolerances, float) if isinstance(tolerances, Tolerances) else tolerances
    p = _with_room(layout, p)
    run, own = _integrate(layout, ids, steps, p, x0, block, directions)
    return _observe(layout, layout.sensed(ids), p, block, directions, run)._replace(own=own)


def _with_room(layout: Layout, p: Float[AnyArray, "P L"]) -> Float[AnyArray, "R L"]:
    """Numbers by slot with rows to spare (`Layout.room`)."""
    more = ((0, layout.room - len(p)), (0, 0))
    return np.pad(p, more) if isinstance(p, np.ndarray) else jnp.pad(p, more)


def _described(layout: Layout, ids: frozenset[str]) -> str | None:
    """All that a program takes from its static arguments, the same in every process.

    Of the package's own effects the names say enough, since the source is part of a program's key
    (`Stored`). Of others the formulas do, and where their numbers stand: nobody can say whether
    their source is all that they depend on.

    Args:
        layout: structure of the model.
        ids: of the effects that the program carries.

    Returns:
        None where an effect's formula cannot be traced alone.
    """
    outside = ids & layout.outside
    slots = [i for e in layout.carried(outside) for i in layout.numbers(e)]
    # a formula does not say which of its numbers are estimated, nor are all of them in its text
    placed = [(layout.parameters[i].name, i, i in layout.estimable) for i in slots]
    try:
        return f"{layout.described(ids)} {placed} {_formulas(layout, outside)}"
    except Exception as fault:  # an effect of the user's that leans on another: it is traced anew
        log.info("A program with %s is not kept: %s", sorted(outside), fault)
        return None


@functools.cache
def _formulas(layout: Layout, ids: frozenset[str]) -> str:
    """Digest of what a model with some effects computes, and of its first two derivatives."""
    if not ids:
        return ""
    one = jax.ShapeDtypeStruct((1,), jnp.float64)
    n = layout.n_states(ids)

    def model(q, piece, left):
        return layout.model(q, piece, left, ids)

    def once(t, y, q, piece, left):
        moved = model(q, piece, left)
        return moved.derivative(t, y), moved.readings(t, y[:4])

    def differentiated(function):
        return lambda *a: jax.jvp(function, a, jax.tree.map(jnp.ones_like, a))

    arguments = (one, (one,) * n, (one,) * len(layout.parameters), (one,) * 4, one)
    text = jax.jit(differentiated(differentiated(once))).lower(*arguments).as_text()
    if n > layout.n_states():
        some = jax.ShapeDtypeStruct((4,), jnp.float64)
        past = jax.jit(lambda t, y, q: _past(model(q, None, None), t, y))
        text += past.lower(some, (some,) * 4, (one,) * len(layout.parameters)).as_text()
    return hashlib.sha256(text.encode()).hexdigest()


class _Rows(NamedTuple):
    """The slots that a program's model looks at: all others are no operand of its operations.

    A layout has slots for every effect, over a hundred; a model with one effect looks at fifty.
    Those handed on in vain cost nothing when a program runs, but they do when it is compiled.

    used: slots; place: (R,) of each slot among them, of those not used that of a zero behind them;
    estimable: places of those that may be asked for; slots: of the layout.
    """

    used: tuple[int, ...]
    place: np.ndarray
    estimable: tuple[int, ...]
    slots: int

    @classmethod
    def of(cls, layout: Layout, ids: frozenset[str], room: int) -> "_Rows":
        """Makes the rows of a model with some effects; `room` rows are there (`Layout.room`)."""
        used = layout.depends(ids)
        place = np.full(room, len(used))
        place[list(used)] = np.arange(len(used))
        estimable = tuple(int(place[i]) for i in layout.estimable if i in used)
        return cls(used, place, estimable, len(layout.parameters))

    def taken(self, p) -> tuple[Array, ...]:
        """The rows that are used, and a zero."""
        return (*(p[i] for i in self.used), 0.0 * p[0])

    def spread(self, q: Sequence) -> list:
        """Puts what is used at its slots; None elsewhere."""
        every: list = [None] * self.slots
        for i, x in zip(self.used, q, strict=False):  # the zero behind them is no slot
            every[i] = x
        return every


def _slots(layout: Layout, p: Sequence[Array] | Array) -> tuple[Array, ...]:
    """Numbers by slot, without what follows them.

    Only a model is made without the rows to spare: a program that is taken for another layout's
    may be asked for derivatives by a slot that its own had not, and must find it in its tables.
    """
    return tuple(p)[: len(layout.parameters)]


@functools.partial(Stored, static=2, describe=_described)
def _integrate(layout, ids, tolerances, p, x0, block, directions):
    """States and tangents of a block's windows, and the effects' own states (L, n, k)."""
    measured = block.pieces is not None
    TRACES.append((layout, ids, p.shape, block.ts.shape, directions.shape, measured))

    rows = _Rows.of(layout, ids, len(p))

    def field(t, y, q, piece, left):
        return layout.model(rows.spread(q), piece, left, ids).derivative(t, y)

    eps = (int(rows.place[layout.index["eps1"]]), int(rows.place[layout.index["eps2"]]))
    lanes = Lanes(block.ts, block.count, block.start, x0, block.pieces)
    steps = Tolerances(*tolerances)
    wanted = jnp.asarray(rows.place)[directions]
    run = integrate(field, rows.taken(p), lanes, eps, wanted, rows.estimable, steps)
    # What follows knows angles and velocities only, and is compiled once for all.
    count = x0.shape[1]
    s = run.s
    if count > 4:
        s = jnp.concatenate([s[..., :4], s[..., count:]], axis=3)
    return run._replace(y=run.y[..., :4], s=s), run.y[..., 4:]


@functools.partial(Stored, static=2, describe=_described)
def _observe(layout, ids, p, block, directions, run) -> Linearised:
    """Readings of integrated windows, less the data."""
    rows = _Rows.of(layout, ids, len(p))
    slots = rows.taken(p)
    y = tuple(jnp.moveaxis(run.y, 2, 0).transpose(0, 2, 1))  # components (n, L)
    measured = block.pieces is not None
    if measured:
        last = jnp.concatenate([block.pieces, block.pieces[-1:]])
        piece = tuple(last.transpose(1, 0, 2))
        left = jnp.concatenate([block.ts[:-1], block.ts[-2:-1]])
    wide = tuple(jnp.broadcast_to(q, block.ts.shape) for q in slots)

    # What acts on the motion alone reaches the readings through the states only.
    depends = list(rows.estimable)
    turn = np.full(len(slots), len(depends))
    turn[depends] = np.arange(len(depends))
    turn = turn[rows.place]

    def observed(f, t, y, q, s):
        """Values (k, m, L) and derivatives (L, m, k, 4 + d) at m samples; s: (L, m, 4, 4 + d)."""
        both = lambda *a: f(t, a[: len(y)], a[len(y) :])  # noqa: E731
        value = both(*y, *q)
        # what is large, s and the result, stays as it lies in memory
        jac = []
        by_state = columns(both, [*y, *q], range(4))
        for i in range(len(value)):
            terms = [(d, s[:, :, k]) for k, by in enumerate(by_state) if (d := by[i]) is not None]
            jac.append(sum(by.T[..., None] * x for by, x in terms))
        if directions.size:
            places = [len(y) + k for k in depends]
            wanted = np.ones((len(value), len(depends)), bool)
            chosen = jnp.asarray(turn)[directions]
            direct = some_columns(both, [*y, *q], places, chosen, wanted)
            pad = ((0, 0), (0, 0), (len(y), 0))
            jac = [
                x if by is None else x + jnp.pad(by.transpose(2, 1, 0), pad)
                for x, by in zip(jac, direct, strict=True)
            ]
        return jnp.stack(value), jnp.stack(jac, axis=2)

    @jax.jit
    def readings(t, y, q):
        model = layout.model(rows.spread(q), *at_piece(q), ids)
        return tuple(model.readings(t, y))

    # The prior takes their rates too. What an effect of the motion does is in the states; the
    # accelerations, of which a sensor's delay takes the square of the delay, are those of the
    # pendulum without.
    @jax.jit
    def and_rates(t, y, q):
        model = layout.model(rows.spread(q), *at_piece(q), ids)
        return model.readings_and_rates(t, y)

    def at_piece(q):
        """The piece of a measured drive, which comes after the slots."""
        return (q[len(slots) : -1], q[-1]) if measured else (None, None)

    def begin(x):
        return jnp.take_along_axis(x, block.begins, axis=0)

    arguments = (*wide, *piece, left) if measured else wide
    value, jac = observed(readings, block.ts, y, arguments, run.s)
    first = tuple(begin(q) for q in arguments)
    lane = jnp.arange(block.ts.shape[1])[:, None]
    prior, prior_jac = observed(
        and_rates, begin(block.ts), tuple(map(begin, y)), first, run.s[lane, block.begins.T]
    )
    weight = block.weight.transpose(1, 0, 2)
    prior_weight = block.prior_weight.transpose(1, 0, 2)
    r = (value - block.data.transpose(1, 0, 2)) * weight
    prior_r = (prior - block.prior.transpose(1, 0, 2)) * prior_weight
    return Linearised(
        r=r.transpose(2, 1, 0),
        jac=jac * weight.T[..., None],
        prior_r=prior_r.transpose(2, 1, 0),
        prior_jac=prior_jac * prior_weight.T[..., None],
        states=run.y,
        complete=run.complete & jnp.all(jnp.isfinite(r), axis=(0, 1)),
        taken=run.taken,
    )


def remember(
    layout: Layout,
    ids: frozenset[str],
    p: Float[AnyArray, "P R"],
    t: Float[AnyArray, "R n"],
    y: Float[AnyArray, "R 4 n"],
    pieces: Float[AnyArray, "R n 4"] | None,
) -> Float[Array, "R k n"]:
    """The effects' own states along motions that are known, from rest at their beginning.

    Args:
        layout: structure of the model; static.
        ids: of effects; static.
        p: all slots for every recording.
        t: sample times.
        y: angles and velocities there.
        pieces: of a measured drive from each sample on.
    """
    return _remember(layout, ids, _with_room(layout, p), t, y, pieces)


@functools.partial(Stored, static=2, describe=_described)
def _remember(layout, ids, p, t, y, pieces):
    def along(p, t, y, piece):
        left = None if piece is None else t
        coefficients = None if piece is None else tuple(piece.T)
        model = layout.model(_slots(layout, p), coefficients, left, ids)
        return _past(model, t, tuple(y))

    return jax.vmap(along, in_axes=(1, 0, 0, None if pieces is None else 0))(p, t, y, pieces)


def _past(model, t, y):
    """Own states (k, n), one effect after the other."""
    found = []
    for term in model.terms:
        if term.n_states:
            bare = dataclasses.replace(model, terms=())
            found += list(term.past(bare.motion(t, y)))
    return jnp.stack(found)
