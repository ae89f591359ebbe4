"""Nelder-Mead as a minimiser of optimistix.

optimistix 0.1.0 has one of its own, which mixes vertices of the old simplex into the new one and
ends in points that are no minima. This one takes SciPy's steps, and serves `optimistix.minimise`
likewise: any pytree, under `jit` and `vmap`.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, PyTree, Scalar

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
    - `lower`, `upper`: pytrees like y; points are clipped to them, as in SciPy.

    Attributes:
        rtol: not used; there for the interface.
        atol: the method ends when no coordinate of a vertex is further from the best than this
            (TolX, xatol)
        ftol: and no value (TolFun, fatol); as atol if None.
        norm: not used; distances are largest absolute values.
        rule: "scipy", or "fminsearch", which lets no tolerance fall below rounding.
        adaptive: coefficients of Gao and Han for many dimensions.
    """

    rtol: float = 0.0
    atol: float = 1e-4
    ftol: float | None = None
    norm: Callable[[PyTree], Scalar] = optx.max_norm
    rule: Rule = eqx.field(default="scipy", static=True)
    adaptive: bool = eqx.field(default=False, static=True)

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> _State:  # noqa: ARG002
        x, _ = ravel_pytree(y)
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
        aux = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), aux_struct)
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
        ftol = self.atol if self.ftol is None else self.ftol
        done = converged(state.simplex, self.atol, ftol, self.rule)
        return done, optx.RESULTS.successful

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
