"""Derivatives of a step: what the run's own differentiation would give, at a fraction of the cost.

With S the derivatives of the state in D directions, a stage `(g - J) k = r` becomes

    (g - J) dk = dr + dJ k,      dr = J_i du + f_p,i + ...,

J_i the Jacobian at the stage's own state and f_p,i the derivatives by the parameters there. All
directions share J, J_i and f_p,i, so that one of them costs a few multiplications; dJ has a few
entries only, from the curvature of friction. Nothing is left out: these are the derivatives of
the numbers that the step computes, its size held fixed.
"""

from collections.abc import Sequence
from typing import NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.columns import columns, some_columns
from tp_jax.simulation.dependence import dependence
from tp_jax.simulation.linear_solve import Jacobian, eliminate
from tp_jax.simulation.step import Field, Restart, Structure, after, combine, jacobian
from tp_jax.simulation.tableau import StageForm

FEW = 2
"""Parameters per direction up to which all are differentiated by, and those asked for taken."""


class Curvature(NamedTuple):
    """Dependence of the entries of the Jacobian on state and parameters.

    entries: places (i, j) of the Jacobian that are not zero; by_state (entries, n) and
    by_parameter (entries, P); field_by_parameter (n, P).
    """

    entries: tuple[tuple[int, int], ...]
    by_state: np.ndarray
    by_parameter: np.ndarray
    field_by_parameter: np.ndarray


def curvature(field: Field, s: Structure, n_parameters: int) -> Curvature:
    """Structure of a field's second derivatives, from its own formulas."""
    n = len(s.by_time)
    one = jax.ShapeDtypeStruct((1,), jnp.float64)
    entries = tuple((int(i), int(j)) for i, j in zip(*np.nonzero(s.by_state), strict=True))

    def flat(t, *rest):
        rows = jacobian(field, s, t, tuple(rest[:n]), tuple(rest[n:]))
        return tuple(_known(rows[i][j], t) for i, j in entries)

    def first(t, *rest):
        return tuple(field(t, rest[:n], rest[n:]))

    d = dependence(flat, one, *[one] * (n + n_parameters))
    f = dependence(first, one, *[one] * (n + n_parameters))
    return Curvature(entries, d[:, 1 : 1 + n], d[:, 1 + n :], f[:, 1 + n :])


class Linear(NamedTuple):
    """Derivatives of a function of (y, p), contracted with directions when asked.

    by_state: list over components of lists over outputs, None where zero; by_direction: list over
    outputs of (nd, L), None where zero.
    """

    by_state: list[list[AnyArray | None]]
    by_direction: list[AnyArray | None]

    def along(self, s: list[Array], n: int) -> list[Array | None]:
        """Change of every output along S (n components, each (n + nd, L))."""
        found: list[Array | None] = []
        for k, mine in enumerate(self.by_direction):
            terms = [
                cast(Array, d * x)  # of one of NumPy's too, since it is multiplied by JAX's
                for row, x in zip(self.by_state, s, strict=True)
                if (d := row[k]) is not None
            ]
            total = sum(terms[1:], terms[0]) if terms else None
            if mine is not None:
                # the first n directions are those of the state
                whole = jnp.concatenate([jnp.zeros((n, mine.shape[1])), mine])
                total = whole if total is None else total + whole
            found.append(total)
        return found


def linear(f, y: list[Array], p: tuple, by_state, by_parameter, directions) -> Linear:
    """Derivatives of `f(y, p)` (a tuple of (L,)), only where the structure has any."""
    n, n_out, one = len(y), by_state.shape[0], y[0]
    states = [k for k in range(n) if by_state[:, k].any()]
    numbers = [k for k in range(len(p)) if by_parameter[:, k].any() and directions.size]
    every = [*y, *p]
    together = lambda *both: f(both[:n], both[n:])  # noqa: E731
    slopes = columns(together, every, states)
    rows: list[list[AnyArray | None]] = [[None] * n_out for _ in range(n)]
    for k, d in zip(states, slopes, strict=True):
        rows[k] = [x if depends else None for x, depends in zip(d, by_state[:, k], strict=True)]
    if not numbers:
        return Linear(rows, [None] * n_out)
    where, wanted = [n + k for k in numbers], by_parameter[:, numbers]
    turn = np.full(len(p), len(numbers))
    turn[numbers] = np.arange(len(numbers))
    if len(numbers) > FEW * directions.size:
        chosen = jnp.asarray(turn)[directions]
        return Linear(rows, some_columns(together, every, where, chosen, wanted))
    slopes = columns(together, every, where)
    found: list[AnyArray | None] = []
    for i, mine in enumerate(wanted):
        values = [d[i] for d, depends in zip(slopes, mine, strict=True) if depends]
        # row of each parameter among those that matter to this output; the last row is zero
        row = np.append(np.where(mine, np.cumsum(mine) - 1, len(values)), len(values))[turn]
        table = [jnp.zeros_like(one) if x is None else x for x in values] + [jnp.zeros_like(one)]
        found.append(jnp.stack(table)[jnp.asarray(row)[directions]] if values else None)
    return Linear(rows, found)


def differentiate(
    field: Field,
    shape: Structure,
    bends: Curvature,
    method: StageForm,
    t: Array,
    h: Array,
    y: list[Array],
    p: tuple,
    stages: list[list[Array]],
    s: list[Array],
    fs: list[Array],
    directions: Int[Array, " d"],
    unit: Array,
    restart: Restart | None = None,
) -> tuple[list[Array], list[Array], list[Array]]:
    """Derivatives of a step.

    Args:
        field, shape, bends: vector field and its structure.
        method, t, h, y, p: as for `advance`; stages: what it found, a list of lists of (L,).
        s, fs: derivatives of y and of f(y), lists of (n + nd, L).
        directions: places in p of the parameters.
        unit: (n + nd, L) ones that the compiler does not know to be ones: what is divided by them
            is evaluated once for all its readers (see `linear_solve`; a quotient by what is the
            same for all directions would be turned into a product).
        restart: lanes that begin a new run, whose derivatives are those of its initial state.

    Returns:
        Derivatives of the state at the end, of f there, and of the embedded error.
    """
    n = len(y)
    rows = jacobian(field, shape, t, tuple(y), p)
    solve = eliminate(rows, 1.0 / (method.gamma * h))

    def entries(y, p):
        found = jacobian(field, shape, t, tuple(y), p)
        return tuple(_known(found[i][j], t) for i, j in bends.entries)

    bent = linear(entries, y, p, bends.by_state, bends.by_parameter, directions).along(s, n)
    ft: list[Array | None] = [None] * n
    if method.d.any() and shape.by_time.any():

        def by_time(y, p):
            return jax.jvp(lambda x: tuple(field(x, y, p)), (t,), (jnp.ones_like(t),))[1]

        depends = shape.by_time[:, None]
        ft = linear(
            by_time,
            y,
            p,
            shape.by_state & depends,
            bends.field_by_parameter & depends,
            directions,
        ).along(s, n)

    # All points of the step at once: what is evaluated once is compiled once.
    points: list[tuple[AnyArray, Sequence[Array], tuple]] = [
        (t + c * h, [y[j] + combine(a, stages, j) for j in range(n)], p)
        for a, c in zip(method.a[1:], method.c[1:], strict=True)
    ]
    end = [y[j] + combine(method.b, stages, j) for j in range(n)]
    points.append(after(t + h, end, p, restart))
    where, states, numbers = zip(*points, strict=True)
    ts = jnp.concatenate(where)
    along = linear(
        lambda y, p: tuple(field(ts, tuple(y), p)),
        [jnp.concatenate(u) for u in zip(*states, strict=True)],
        tuple(jnp.concatenate(q) for q in zip(*numbers, strict=True)),
        shape.by_state,
        bends.field_by_parameter,
        directions,
    )

    def change(i: int, s: list[Array]) -> list[Array | None]:
        """Change of the field at one of the points along S."""
        part = slice(i * t.size, (i + 1) * t.size)
        return jax.tree.map(lambda x: x[..., part], along).along(s, n)

    tangents: list[list[Array]] = []
    for i, k in enumerate(stages):
        if i:
            du = [s[j] + combine(method.a[i], tangents, j) for j in range(n)]
            sums = [combine(method.C[i], tangents, j) for j in range(n)]
            right = [
                (x if c is None else x + h * c) / h
                for c, x in zip(change(i - 1, du), sums, strict=True)
            ]
        else:
            right = list(fs)
        if method.d[i]:
            right = [
                r if x is None else r + (method.d[i] * h) * x
                for r, x in zip(right, ft, strict=True)
            ]
        for (a, b), x in zip(bends.entries, bent, strict=True):
            if x is not None:
                right[a] = right[a] + x * k[b]
        tangents.append([x / unit for x in solve([x / unit for x in right])])
    s_end = [(s[j] + combine(method.b, tangents, j)) / unit for j in range(n)]
    if restart is not None:
        s_end = [
            jnp.where(restart.where, a, b) for a, b in zip(initial(n, unit), s_end, strict=True)
        ]
    f_end = change(len(points) - 1, s_end)
    error = [combine(method.b_error, tangents, j) for j in range(n)]
    zero = jnp.zeros_like(s[0])
    return s_end, [zero if x is None else x / unit for x in f_end], error


def _known(x: AnyArray | None, like: Array) -> AnyArray:
    """An entry of the Jacobian as an array, also where its structure promised more than it has."""
    return jnp.zeros_like(like) if x is None else x


def initial(n: int, like: Array) -> list[Array]:
    """Derivatives (D, L) of the n components of an initial state."""
    return [jnp.zeros_like(like).at[j].set(1.0) for j in range(n)]


__all__ = ["Curvature", "Jacobian", "curvature", "differentiate", "initial"]
