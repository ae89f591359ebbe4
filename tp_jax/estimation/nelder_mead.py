"""Nelder-Mead as a minimiser of optimistix, from one simplex or from many at once.

optimistix 0.1.0 has one of its own, which mixes vertices of the old simplex into the new one and
ends in points that are no minima. This one takes SciPy's steps, and serves `optimistix.minimise`
likewise: any pytree, under `jit` and `vmap`.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, Int, PyTree, Scalar

from tp_jax.estimation.simplex import (
    Box,
    Coefficients,
    Rule,
    Simplex,
    absorb,
    adaptive_coefficients,
    begin,
    converged,
    initial_simplex,
)
from tp_jax.model.arrays import AnyArray

CHUNK = 4
"""Evaluations between two looks at which lanes go on."""


class _State(eqx.Module):
    simplex: Simplex
    best: Scalar
    aux: PyTree


class NelderMead(optx.AbstractMinimiser):
    """The Nelder-Mead method, for `optimistix.minimise`.

    One step is one evaluation of the function, not one iteration, so that under `vmap` no lane
    waits for another's shrink, and a lane that has ended stays as it is. `max_steps` bounds the
    evaluations, SciPy's `maxfev`. The state's `simplex` holds vertices, values and the number of
    iterations.

    Options of `optimistix.minimise`:

    - `simplex`: the initial vertices, a pytree like y with an axis of n + 1 before the others;
      without it, `fminsearch`'s around y (five per cent of each coordinate, 0.00025 of a zero).
    - `resume`: a `Simplex` of an earlier call's state, to go on from.
    - `lower`, `upper`: pytrees like y; points are clipped to them, as in SciPy.

    Attributes:
        rtol: not used; there for the interface.
        atol: the method ends when no coordinate of a vertex is further from the best than this
            (TolX, xatol)
        ftol: and no value (TolFun, fatol); as atol if None.
        norm: not used; distances are largest absolute values.
        rule: "scipy", or "fminsearch", which lets no tolerance fall below rounding.
        adaptive: coefficients of Gao and Han for many dimensions.
        max_iterations: it ends after so many too, whatever the tolerances.
    """

    rtol: float = 0.0
    atol: float = 1e-4
    ftol: float | None = None
    norm: Callable[[PyTree], Scalar] = optx.max_norm
    rule: Rule = eqx.field(default="scipy", static=True)
    adaptive: bool = eqx.field(default=False, static=True)
    max_iterations: int | AnyArray | None = None

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> _State:  # noqa: ARG002
        x, _ = ravel_pytree(y)
        aux = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), aux_struct)
        if options.get("resume") is not None:
            simplex = options["resume"]
            return _State(simplex, jnp.min(simplex.values), aux)
        given = options.get("simplex")
        if given is None:
            vertices = initial_simplex(x, self._box(y, options))
        else:
            vertices = jax.vmap(lambda each: ravel_pytree(each)[0])(given)
            if vertices.shape != (x.size + 1, x.size):
                raise ValueError(
                    f"Option `simplex` must hold {x.size + 1} vertices of {x.size} coordinates, "
                    f"but holds {vertices.shape[0]} of {vertices.shape[1]}."
                )
        vertices = self._box(y, options).clip(vertices.astype(f_struct.dtype))
        return _State(begin(vertices), jnp.asarray(jnp.inf, f_struct.dtype), aux)

    def step(self, fn, y, args, options, state, tags):  # noqa: ARG002
        _, unravel = ravel_pytree(y)
        s = state.simplex
        value, aux = fn(unravel(s.trial), args)
        after = absorb(s, value, self._box(y, options), self._coefficients(s.trial.size))
        better = value < state.best
        best = jnp.where(better, value, state.best)
        keep = lambda new, old: jnp.where(better, new, old)  # noqa: E731
        aux = jax.tree.map(keep, aux, state.aux)
        x = jnp.where(better, s.trial, ravel_pytree(y)[0])
        return unravel(x), _State(after, best, aux), aux

    def terminate(self, fn, y, args, options, state, tags) -> tuple[Bool[Array, ""], Any]:  # noqa: ARG002
        return self.ended(state.simplex), optx.RESULTS.successful

    def ended(self, s: Simplex) -> Bool[Array, ""]:
        """True where the search ends here."""
        done = self.converged(s)
        if self.max_iterations is None:
            return done
        return done | (s.between & (s.iterations >= self.max_iterations))

    def converged(self, s: Simplex) -> Bool[Array, ""]:
        """True where the simplex is smaller than the tolerances."""
        return converged(s, self.atol, self.atol if self.ftol is None else self.ftol, self.rule)

    def postprocess(self, fn, y, aux, args, options, state, tags, result):  # noqa: ARG002
        s = state.simplex
        return y, aux, {"iterations": s.iterations, "evaluations": s.evaluations}

    def _box(self, y: PyTree, options: dict[str, Any]) -> Box:
        x, _ = ravel_pytree(y)
        ends = [
            jnp.full_like(x, free) if options.get(name) is None else ravel_pytree(options[name])[0]
            for name, free in (("lower", -jnp.inf), ("upper", jnp.inf))
        ]
        return Box(*ends)

    def _coefficients(self, n: int) -> Coefficients:
        return adaptive_coefficients(n) if self.adaptive else Coefficients()


class Searched(NamedTuple):
    """Result of `minimise_many`, by lane.

    x: (L, n) the best vertices; value: (L,) there; converged: (L,) whether the simplex is smaller
    than the tolerances; iterations, evaluations: (L,).
    """

    x: Float[np.ndarray, "L n"]
    value: Float[np.ndarray, " L"]
    converged: Bool[np.ndarray, " L"]
    iterations: Int[np.ndarray, " L"]
    evaluations: Int[np.ndarray, " L"]


def minimise_many(
    fn: Callable[[Array, Any, Array], Scalar],
    solver: NelderMead,
    simplices: Float[np.ndarray, "L m n"],
    args: Any = None,
    *,
    max_steps: int | None = None,
    callback: Callable[[Simplex], None] | None = None,
) -> Searched:
    """`optimistix.minimise` under `vmap` over initial simplices, in chunks of steps.

    Between two chunks the lanes that go on are brought to the front, and `fn` learns how many they
    are: one that works on all lanes at once (`jax.custom_batching.custom_vmap`) spends nothing on
    those that have ended.

    Args:
        fn: of a point (n,), what belongs to its lane, and the number of lanes that count, each of
            them before those that do not. An `equinox.Module` or a function made once, so that a
            second call compiles nothing.
        solver: the method.
        simplices: to begin with, see `initial_simplex`.
        args: pytree of arrays with an axis of lanes, handed to `fn` lane by lane.
        max_steps: evaluations of a lane from which on no further chunk begins.
        callback: called with all lanes after each chunk.
    """
    room = 1 << (len(simplices) - 1).bit_length()  # few sizes, since each is a program of its own
    fill = lambda x: np.concatenate([x, np.repeat(x[:1], room - len(x), axis=0)])  # noqa: E731
    args = jax.tree.map(lambda x: fill(np.asarray(x)), args)
    vertices = fill(np.asarray(simplices, float))
    lanes = jax.tree.map(np.array, _begun(fn, vertices, args, np.array(len(simplices))))
    real = np.arange(room) < len(simplices)
    ended = jax.jit(jax.vmap(solver.ended))
    while True:
        on = real & ~np.asarray(ended(lanes))
        if max_steps is not None:
            on &= lanes.evaluations < max_steps
        if not on.any():
            break
        turn = np.argsort(~on, kind="stable")
        part = lambda tree: jax.tree.map(lambda x: x[turn], tree)  # noqa: B023, E731
        after = _chunk(fn, solver, part(lanes), part(args), np.array(on.sum()))
        for whole, new in zip(lanes, after, strict=True):
            whole[turn[: on.sum()]] = np.asarray(new)[: on.sum()]
        if callback is not None:
            callback(jax.tree.map(lambda x: x[: len(simplices)], lanes))
    lanes = jax.tree.map(lambda x: x[: len(simplices)], lanes)
    lane, best = np.arange(len(simplices)), np.argmin(lanes.values, axis=1)
    return Searched(
        lanes.vertices[lane, best],
        lanes.values[lane, best],
        np.asarray(jax.vmap(solver.converged)(lanes)),
        lanes.iterations,
        lanes.evaluations,
    )


@eqx.filter_jit
def _begun(fn: Callable, vertices: AnyArray, args: Any, active: AnyArray) -> Simplex:
    """Lanes with the values of their first vertices, which are asked for together."""
    size = vertices.shape[1]
    each = jax.tree.map(lambda x: jnp.repeat(x, size, axis=0), args)
    points = vertices.reshape(-1, vertices.shape[2])
    values = jax.vmap(lambda x, a: fn(x, a, active * size))(points, each)
    free = jnp.full(vertices.shape[2], jnp.inf)

    def one(vertices, values) -> Simplex:
        put = lambda s, value: (absorb(s, value, Box(-free, free), Coefficients()), None)  # noqa: E731
        return jax.lax.scan(put, begin(vertices), values)[0]

    return jax.vmap(one)(vertices, values.reshape(-1, size))


@eqx.filter_jit
def _chunk(
    fn: Callable, solver: NelderMead, lanes: Simplex, args: Any, active: AnyArray
) -> Simplex:
    """All lanes after `CHUNK` evaluations more."""

    def one(simplex: Simplex, args: Any) -> Simplex:
        best = simplex.vertices[jnp.argmin(simplex.values)]
        found = optx.minimise(
            lambda y, _: fn(y, args, active),
            solver,
            best,
            options={"resume": simplex},
            max_steps=CHUNK,
            throw=False,
        )
        return found.state.simplex

    return jax.vmap(one)(lanes, args)
