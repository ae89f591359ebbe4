"""Many Nelder-Mead searches at once, for a function that is dear and evaluated in batches.

`optimistix.minimise` under `vmap` wants a function that JAX can trace. Here the function takes
any number of points, as `tp_jax.sweep` takes any number of pendulums, and only what is needed is
evaluated: lanes that have ended ask for nothing, the vertices of a first or shrunk simplex are
asked for together.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from tp_jax.estimation.simplex import (
    REFLECTION,
    SHRUNK,
    VERTEX,
    Box,
    Coefficients,
    Rule,
    Simplex,
    absorb,
    adaptive_coefficients,
    begin,
    candidates,
    converged,
)

CONVERGED = "The simplex is smaller than its tolerances."
EXHAUSTED = "The limit of iterations or evaluations was reached."


class Found(NamedTuple):
    """What `minimise_batch` returns, by lane.

    x: (L, n) the best vertices; value: (L,) there; converged: (L,) bool; iterations, evaluations:
    (L,); calls: of the objective; simplex: all vertices and their values.
    """

    x: Float[Array, "L n"]
    value: Float[Array, " L"]
    converged: Float[Array, " L"]
    iterations: Int[Array, " L"]
    evaluations: Int[Array, " L"]
    calls: int
    simplex: Simplex


def minimise_batch(
    objective: Callable[[np.ndarray, np.ndarray], np.ndarray],
    vertices: np.ndarray,
    *,
    lower: np.ndarray | None = None,
    upper: np.ndarray | None = None,
    xtol: float = 1e-4,
    ftol: float = 1e-4,
    rule: Rule = "scipy",
    adaptive: bool = False,
    ahead: bool = False,
    max_iterations: int | None = None,
    max_evaluations: int | None = None,
    callback: Callable[[Simplex], None] | None = None,
) -> Found:
    """Minimises from many initial simplices.

    Args:
        objective: of (m, n) points and the (m,) lanes that ask for them, gives (m,) values; m
            differs from call to call. Infinite where there is none.
        vertices: (L, n + 1, n) initial simplices, see `initial_simplex`.
        lower, upper: (n,) bounds.
        xtol, ftol, rule: see `simplex.converged`.
        adaptive: coefficients for many dimensions.
        ahead: evaluate expansion and contractions together with the reflection: four points
            where one or two would do, but one call for nearly every iteration. Worth it where a
            call takes as long for many points as for one.
        max_iterations, max_evaluations: of a lane; 200 n each if both are None, as in SciPy and
            `fminsearch`.
        callback: called with the lanes after each call of the objective.

    Returns:
        See `Found`.
    """
    vertices = np.asarray(vertices, dtype=float)
    n = vertices.shape[-1]
    if max_iterations is None and max_evaluations is None:
        max_iterations = max_evaluations = 200 * n
    low = np.full(n, -np.inf) if lower is None else np.asarray(lower, float)
    high = np.full(n, np.inf) if upper is None else np.asarray(upper, float)
    box = Box(jnp.asarray(low), jnp.asarray(high))
    c = adaptive_coefficients(n) if adaptive else Coefficients()
    lanes = jax.vmap(begin)(box.clip(jnp.asarray(vertices)))
    ended = jax.jit(jax.vmap(lambda s: converged(s, xtol, ftol, rule)))
    calls = 0
    while True:
        open_ = ~np.asarray(ended(lanes))
        spent = np.asarray(lanes.evaluations), np.asarray(lanes.iterations)
        for limit, used in zip((max_evaluations, max_iterations), spent, strict=True):
            if limit is not None:
                open_ &= ~(np.asarray(lanes.between) & (used >= limit))
        if not open_.any():
            break
        points, asked = _wanted(lanes, box, c, ahead and n > 0)
        asked &= open_[:, None]
        values = np.full(asked.shape, np.nan)
        values[asked] = objective(points[asked], np.nonzero(asked)[0])
        calls += 1
        lanes = _fed(lanes, values, asked, box, c)
        if callback is not None:
            callback(lanes)
    x, f = np.asarray(lanes.vertices), np.asarray(lanes.values)
    best = np.argmin(f, axis=1)
    lane = np.arange(len(best))
    return Found(
        x[lane, best], f[lane, best], np.asarray(ended(lanes)), np.asarray(lanes.iterations),
        np.asarray(lanes.evaluations), calls, lanes,
    )  # fmt: skip


def _wanted(lanes: Simplex, box: Box, c: Coefficients, ahead: bool) -> tuple:
    """Points (L, s, n) that lanes may need before their next, and which of them to ask for (L, s).

    Place 0 is the trial point; 1 to 3 are expansion and contractions. Vertices evaluated in turn
    take a place each, the next one first.
    """
    vertices, waits = np.asarray(lanes.vertices), np.asarray(lanes.waits)
    count, m, n = vertices.shape
    places = max(4, m)
    points = np.zeros((count, places, n))
    points[:, 0] = np.asarray(lanes.trial)
    asked = np.zeros((count, places), bool)
    asked[:, 0] = True
    reflects = waits == REFLECTION
    if ahead and reflects.any():
        points[reflects, 1:4] = np.asarray(_candidates(lanes, box, c))[reflects]
        asked[reflects, 1:4] = True
    for lane in np.flatnonzero((waits == VERTEX) | (waits == SHRUNK)):
        left = vertices[lane, int(lanes.vertex[lane]) :]
        points[lane, : len(left)] = left
        asked[lane, : len(left)] = True
    return points, asked


def _fed(
    lanes: Simplex, values: np.ndarray, asked: np.ndarray, box: Box, c: Coefficients
) -> Simplex:
    """The lanes after all values that they go on to need have been absorbed."""
    began = np.asarray(lanes.waits)
    in_turn = (began == VERTEX) | (began == SHRUNK)
    first = np.asarray(lanes.vertex)
    moving = asked[:, 0]
    lane = np.arange(began.size)
    place = np.zeros(began.size, int)
    while moving.any():
        lanes = _absorb(lanes, jnp.asarray(values[lane, place]), jnp.asarray(moving), box, c)
        waits = np.asarray(lanes.waits)
        # a vertex's place follows from its number, that of a second point from its kind
        place = np.where(in_turn, np.asarray(lanes.vertex) - first, waits - REFLECTION)
        same = np.where(in_turn, waits == began, (began == REFLECTION) & (place > 0) & (place < 4))
        place = np.where(same, place, 0)
        moving = moving & same & asked[lane, place]
    return lanes


@jax.jit
def _absorb(lanes: Simplex, values: Array, moving: Array, box: Box, c: Coefficients) -> Simplex:
    after = jax.vmap(absorb, in_axes=(0, 0, None, None))(lanes, values, box, c)
    pick = jax.vmap(lambda m, new, old: jax.tree.map(lambda a, b: jnp.where(m, a, b), new, old))
    return pick(moving, after, lanes)


@jax.jit
def _candidates(lanes: Simplex, box: Box, c: Coefficients) -> Array:
    return jax.vmap(candidates, in_axes=(0, None, None))(lanes, box, c)
