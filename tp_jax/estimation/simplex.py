"""The simplex of Nelder and Mead, one function value at a time.

A lane asks for the value at its `trial` point and `absorb`s it. What comes next (the reflected
point, an expansion, a contraction, the next vertex of a shrink) follows from that. So a minimiser
needs one evaluation per step whatever the lane is at, and lanes side by side never wait for
another's shrink.

Source: Nelder and Mead (1965), Comput. J. 7:308, in the form of Lagarias et al. (1998), SIAM J.
Optim. 9:112, which MATLAB's `fminsearch` and SciPy follow; coefficients for many dimensions from
Gao and Han (2012), Comput. Optim. Appl. 51:259.
"""

from typing import Literal, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from tp_jax.model.arrays import AnyArray

Rule = Literal["scipy", "fminsearch"]

# What a lane waits for.
VERTEX, REFLECTION, EXPANSION, OUTSIDE, INSIDE, SHRUNK = range(6)

RELATIVE = 0.05  # `fminsearch` and SciPy: each coordinate in turn five per cent larger,
ABSOLUTE = 0.00025  # or this where it is zero


class Coefficients(NamedTuple):
    """Coefficients of reflection, expansion, contraction and shrinking."""

    reflect: float = 1.0
    expand: float = 2.0
    contract: float = 0.5
    shrink: float = 0.5


class Box(NamedTuple):
    """Bounds (n,) to which every point is clipped; infinite where there is none."""

    lower: Float[Array, " n"]
    upper: Float[Array, " n"]

    def clip(self, x: Float[Array, "... n"]) -> Float[Array, "... n"]:
        """The nearest point inside."""
        return jnp.clip(x, self.lower, self.upper)


class Simplex(NamedTuple):
    """A lane of the method.

    vertices: (n + 1, n), best first once all are known; values: (n + 1,); trial: (n,), the point
    whose value is wanted; waits: for what; vertex: which one, while vertices are evaluated in
    turn; reflected, at_reflected: kept for the second evaluation of an iteration; iterations;
    evaluations.
    """

    vertices: Float[Array, "m n"]
    values: Float[Array, " m"]
    trial: Float[Array, " n"]
    waits: Int[Array, ""]
    vertex: Int[Array, ""]
    reflected: Float[Array, " n"]
    at_reflected: Float[Array, ""]
    iterations: Int[Array, ""]
    evaluations: Int[Array, ""]

    @property
    def between(self) -> Bool[Array, ""]:
        """True where an iteration has just ended: all vertices have their values, in order."""
        return self.waits == REFLECTION


def initial_simplex(x: Float[AnyArray, "... n"], box: Box | None = None) -> Float[Array, "... m n"]:
    """The simplex that `fminsearch` and SciPy build around a start.

    Args:
        x: starts.
        box: bounds. As in SciPy, a vertex beyond the upper bound is reflected to the inside, so
            that a start at its bound does not make the simplex flat.

    Returns:
        m = n + 1 vertices for each start, the start first.
    """
    x = jnp.asarray(x, float)
    n = x.shape[-1]
    box = Box(jnp.full(n, -jnp.inf), jnp.full(n, jnp.inf)) if box is None else box
    x = box.clip(x)
    moved = jnp.where(x != 0.0, (1.0 + RELATIVE) * x, ABSOLUTE)
    others = jnp.where(jnp.eye(n, dtype=bool), moved[..., None, :], x[..., None, :])
    vertices = jnp.concatenate([x[..., None, :], others], axis=-2)
    return box.clip(jnp.where(vertices > box.upper, 2.0 * box.upper - vertices, vertices))


def adaptive_coefficients(n: int) -> Coefficients:
    """Returns the coefficients of Gao and Han for n dimensions."""
    return Coefficients(1.0, 1.0 + 2.0 / n, 0.75 - 1.0 / (2.0 * n), 1.0 - 1.0 / n)


def begin(vertices: Float[Array, "m n"]) -> Simplex:
    """A lane before its first evaluation."""
    m = vertices.shape[0]
    zero = jnp.zeros((), int)
    return Simplex(
        vertices,
        jnp.full(m, jnp.inf, vertices.dtype),
        vertices[0],
        zero + VERTEX,
        zero,
        vertices[0],
        jnp.asarray(jnp.inf, vertices.dtype),
        zero,
        zero,
    )


def along(s: Simplex, factor: float, box: Box) -> Float[Array, " n"]:
    """The point `factor` times as far behind the centroid of the others as the worst lies before.

    1 reflects, a negative factor contracts to the inside.
    """
    n = s.vertices.shape[1]
    centroid = sum((s.vertices[i] for i in range(1, n)), s.vertices[0]) / n
    return box.clip((1.0 + factor) * centroid - factor * s.vertices[-1])


def candidates(s: Simplex, box: Box, c: Coefficients) -> Float[Array, "3 n"]:
    """The expansion and the contractions to the outside and to the inside."""
    factors = (c.reflect * c.expand, c.contract * c.reflect, -c.contract)
    return jnp.stack([along(s, f, box) for f in factors])


def absorb(s: Simplex, value: Float[Array, ""], box: Box, c: Coefficients) -> Simplex:
    """The lane after the value at its trial point has become known."""
    m = s.vertices.shape[0]
    s = s._replace(evaluations=s.evaluations + 1)
    in_turn = (s.waits == VERTEX) | (s.waits == SHRUNK)
    values = s.values.at[s.vertex].set(jnp.where(in_turn, value, s.values[s.vertex]))
    last = in_turn & (s.vertex == m - 1)

    best, second_worst, worst = s.values[0], s.values[-2], s.values[-1]
    reflection = s.waits == REFLECTION
    expand = reflection & (value < best)
    # in this order, and with these comparisons, also where values tie or are NaN
    keep_reflection = reflection & ~expand & (value < second_worst)
    outside = reflection & ~expand & ~keep_reflection & (value < worst)
    inside = reflection & ~expand & ~keep_reflection & ~outside

    good = (
        ((s.waits == EXPANSION) & (value < s.at_reflected))
        | ((s.waits == OUTSIDE) & (value <= s.at_reflected))
        | ((s.waits == INSIDE) & (value < worst))
    )
    take_trial = keep_reflection | good
    take_reflection = (s.waits == EXPANSION) & ~good
    shrink = ((s.waits == OUTSIDE) | (s.waits == INSIDE)) & ~good

    new = jnp.where(take_reflection, s.reflected, s.trial)
    at_new = jnp.where(take_reflection, s.at_reflected, value)
    taken = take_trial | take_reflection
    vertices = s.vertices.at[-1].set(jnp.where(taken, new, s.vertices[-1]))
    values = values.at[-1].set(jnp.where(taken, at_new, values[-1]))
    shrunk = box.clip(s.vertices[0] + c.shrink * (s.vertices - s.vertices[0]))
    vertices = jnp.where(shrink, shrunk.at[0].set(s.vertices[0]), vertices)

    ended = taken | last  # all vertices have values
    order = jnp.argsort(values, stable=True)
    vertices = jnp.where(ended, vertices[order], vertices)
    values = jnp.where(ended, values[order], values)
    waits = jnp.select(
        [ended, expand, outside, inside, shrink],
        [REFLECTION, EXPANSION, OUTSIDE, INSIDE, SHRUNK],
        s.waits,
    )
    vertex = jnp.select([ended, shrink, in_turn], [0, 1, s.vertex + 1], s.vertex)
    after = s._replace(
        vertices=vertices,
        values=values,
        waits=waits,
        vertex=vertex,
        reflected=jnp.where(reflection, s.trial, s.reflected),
        at_reflected=jnp.where(reflection, value, s.at_reflected),
        iterations=s.iterations + (taken | (last & (s.waits == SHRUNK))),
    )
    further = candidates(after, box, c)
    trial = jnp.select(
        [ended, expand, outside, inside],
        [along(after, c.reflect, box), further[0], further[1], further[2]],
        after.vertices[jnp.minimum(vertex, m - 1)],
    )
    return after._replace(trial=trial)


def converged(s: Simplex, xtol: float | Array, ftol: float | Array, rule: Rule) -> Bool[Array, ""]:
    """True where all vertices lie within xtol of the best, coordinate by coordinate, and all values
    within ftol of the best value: TolX and TolFun. `fminsearch` lets neither fall below ten
    spacings of floating point numbers."""
    far = jnp.max(jnp.abs(s.vertices[1:] - s.vertices[0]))
    apart = jnp.max(jnp.abs(s.values[0] - s.values[1:]))
    if rule == "fminsearch":
        xtol = jnp.maximum(xtol, 10.0 * _spacing(jnp.max(s.vertices[0])))
        ftol = jnp.maximum(ftol, 10.0 * _spacing(s.values[0]))
    return s.between & (far <= xtol) & (apart <= ftol)


def _spacing(x: Float[Array, ""]) -> Float[Array, ""]:
    """Distance from |x| to the next larger floating point number."""
    size = jnp.abs(x)
    return jnp.nextafter(size, jnp.inf) - size
