"""One linearly implicit step of many lanes at once, and what lies inside it.

All quantities are lists of components, each (L,), rather than arrays of them: what is stacked
has to be taken apart again by every reader.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.columns import columns
from tp_jax.simulation.dependence import dependence
from tp_jax.simulation.linear_solve import Jacobian, eliminate
from tp_jax.simulation.tableau import StageForm

#: field(t, y, p) -> derivatives of y; y and p are tuples of arrays (L,), t is (L,).
Field = Callable[..., tuple]


class Structure(NamedTuple):
    """Dependence of derivatives on state and time: by_state (n, n), by_time (n,)."""

    by_state: np.ndarray
    by_time: np.ndarray


class Restart(NamedTuple):
    """Lanes that do not step but go on from elsewhere.

    where: (L,) which; t: (L,) time there [s]; y: list of (L,), the state; p: tuple of (L,), the
    parameters there.
    """

    where: Array
    t: Array
    y: list[Array]
    p: tuple


class Stepped(NamedTuple):
    """A step: state y and its derivatives f at the end, embedded errors, stages, and the Jacobian
    at its beginning; of (L,).
    """

    y: list[Array]
    f: list[Array]
    error: list[Array]
    stages: list[list[Array]]
    jacobian: Jacobian


def structure(field: Field, n_states: int, n_parameters: int) -> Structure:
    """Structure of a field's Jacobian, from its own formulas."""
    one = jax.ShapeDtypeStruct((1,), jnp.float64)

    def flat(t, *rest):
        return tuple(field(t, rest[:n_states], rest[n_states:]))

    d = dependence(flat, one, *[one] * (n_states + n_parameters))
    return Structure(d[:, 1 : 1 + n_states], d[:, 0])


def jacobian(field: Field, s: Structure, t: AnyArray | float, y: tuple, p: tuple) -> Jacobian:
    """Derivatives by the states, column by column; None where zero by structure."""
    n = len(y)
    rows: list[list[AnyArray | None]] = [[None] * n for _ in range(n)]
    which = [j for j in range(n) if s.by_state[:, j].any()]
    found = columns(lambda *y: tuple(field(t, y, p)), y, which)
    for j, column in zip(which, found, strict=True):
        for i in range(n):
            if s.by_state[i, j]:
                rows[i][j] = column[i]
    return rows


def advance(
    field: Field,
    s: Structure,
    method: StageForm,
    t: Float[AnyArray, "..."] | float,
    h: Float[Array, "..."],
    y: list[Array],
    f: list[Array],
    p: tuple,
    restart: Restart | None = None,
) -> Stepped:
    """One step of size h from state y with derivatives f."""
    n = len(y)
    jac = jacobian(field, s, t, tuple(y), p)
    solve = eliminate(jac, 1.0 / (method.gamma * h))
    by_time: list = [None] * n
    if method.d.any() and s.by_time.any():
        rates = jax.jvp(lambda x: tuple(field(x, tuple(y), p)), (t,), (jnp.ones_like(t),))[1]
        by_time = [r if depends else None for r, depends in zip(rates, s.by_time, strict=True)]
    stages: list[list[Array]] = []
    for i in range(len(method.c)):
        if i:
            at = [y[j] + combine(method.a[i], stages, j) for j in range(n)]
            value = field(t + method.c[i] * h, tuple(at), p)
            right = [(combine(method.C[i], stages, j) + h * value[j]) / h for j in range(n)]
        else:
            right = list(f)
        if method.d[i]:
            right = [
                r if ft is None else r + (method.d[i] * h) * ft
                for r, ft in zip(right, by_time, strict=True)
            ]
        stages.append(solve(right))
    end = [settle(y[j] + combine(method.b, stages, j), h) for j in range(n)]
    error = [combine(method.b_error, stages, j) for j in range(n)]
    return Stepped(end, list(field(*after(t + h, end, p, restart))), error, stages, jac)


def after(
    t: AnyArray, y: list[Array], p: tuple, restart: Restart | None
) -> tuple[AnyArray, tuple, tuple]:
    """Returns the point that a step has come to, or from which its lane goes on instead."""
    if restart is None:
        return t, tuple(y), p
    choose = lambda a, b: b if a is b else jnp.where(restart.where, a, b)  # noqa: E731
    return (
        choose(restart.t, t),
        tuple(choose(a, b) for a, b in zip(restart.y, y, strict=True)),
        tuple(choose(a, b) for a, b in zip(restart.p, p, strict=True)),
    )


def settle(x: Array, h: Array) -> Array:
    """`x` as a quotient, which a compiler evaluates once for all its readers (`linear_solve`)."""
    return (x * h) / h


def combine(weights: np.ndarray, stages: list[list[Array]], j: int) -> Array:
    """Weighted sum of component j of the first stages."""
    terms = [k[j] if w == 1.0 else w * k[j] for w, k in zip(weights, stages, strict=False) if w]
    return sum(terms[1:], terms[0])


def between(
    xs: Sequence[AnyArray],
    h: Array,
    y: list[Array],
    f: list[Array],
    end: list[Array],
    f_end: list[Array],
    rate: Array | float,
    velocities: bool,
) -> list[list[Array]]:
    """Angles and velocities inside a step, by quintic Hermite interpolation of the angles.

    Args:
        xs: where, as parts of the step, each (L,).
        h: (L,) step [s]; y, f, end, f_end: state and derivatives at its ends.
        rate: true seconds per recorded second.
        velocities: whether they are wanted.

    Returns:
        For each x both angles [rad], then both velocities [rad/s].
    """
    found: list[list[Array]] = [[] for _ in xs]
    slopes: list[list[Array]] = [[] for _ in xs]
    for c in (0, 1):
        v0, v1 = f[c] * h, f_end[c] * h
        a0, a1 = rate * f[c + 2] * h * h, rate * f_end[c + 2] * h * h
        drop = end[c] - y[c] - v0 - 0.5 * a0
        turn = v1 - v0 - a0
        bend = a1 - a0
        c3 = 10.0 * drop - 4.0 * turn + 0.5 * bend
        c4 = -15.0 * drop + 7.0 * turn - bend
        c5 = 6.0 * drop - 3.0 * turn + 0.5 * bend
        for r, x in enumerate(xs):
            found[r].append(y[c] + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5)))))
            slope = v0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
            slopes[r].append(slope / (h * rate))
    return [a + v for a, v in zip(found, slopes, strict=True)] if velocities else found
