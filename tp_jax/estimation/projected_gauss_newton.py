"""Variable projection as a least-squares solver of optimistix.

`optimistix.least_squares` takes it like `optimistix.LevenbergMarquardt`. The function that it is
meant for has the nuisances of a separable problem, such as the windows' states, eliminated inside
(`window_residuals`). What is left are damped Gauss-Newton steps, taken, refused and ended by the
rules of `variable_projection.fit`: a step ends the search when it promises too small a drop of the
sum of squares, where optimistix' own methods ask that the last step be short.

Source: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10:413; damping relative to the diagonal:
Marquardt (1963), J. SIAM 11:431.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, PyTree, Scalar

import tp_jax._float64  # noqa: F401

FIRST = 1e-4  # damping of the first step: near enough to Gauss-Newton's own
LEAST, MOST = 1e-9, 1e6  # damping; what helps no more at the most is a kink
RANK = 1e-13  # relative eigenvalue below which the residuals do not tell a direction
#: A refused step may have promised so many times what counts as nothing: where kinks roughen the
#: sum of squares, such a promise may not be kept.
ROUGH = 30.0


class _State(eqx.Module):
    """The accepted point's half gradient g (u,), Gauss-Newton matrix H (u, u), sum of squares and
    auxiliary output; the next point to look at, what it promises, and how."""

    g: Float[Array, " u"]
    H: Float[Array, "u u"]
    cost: Scalar
    aux: PyTree
    y_eval: PyTree
    promise: Scalar
    damping: Scalar
    refused: Bool[Array, ""]
    end: Bool[Array, ""]


class VariableProjection(optx.AbstractLeastSquaresSolver):
    """Damped Gauss-Newton steps on projected residuals, for `optimistix.least_squares`.

    A step is one evaluation of the residuals with their Jacobian, by forward-mode derivatives.

    Attributes:
        rtol: the search ends where the next step promises a drop of the sum of squares below this
            part of it,
        atol: or below this, in squared units of the residuals; 0.02 is far less than noise of unit
            variance scatters the sum.
        norm: not used, since a promise needs none; there for the interface.
    """

    rtol: float | Array = 1e-6
    atol: float | Array = 0.02
    norm: Callable[[PyTree], Scalar] = optx.max_norm

    def init(self, fn, y, args, options, f_struct, aux_struct, tags) -> _State:  # noqa: ARG002
        x, _ = ravel_pytree(y)
        zero = jnp.zeros((), x.dtype)
        return _State(
            g=jnp.zeros_like(x),
            H=jnp.eye(x.size, dtype=x.dtype),
            cost=zero + jnp.inf,
            aux=jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), aux_struct),
            y_eval=y,
            promise=zero,
            damping=zero + FIRST,
            refused=jnp.array(False),
            end=jnp.array(False),
        )

    def step(self, fn, y, args, options, state, tags):  # noqa: ARG002
        x, unravel = ravel_pytree(state.y_eval)
        flat = lambda x: fn(unravel(x), args)  # noqa: E731
        r, push, aux = jax.linearize(flat, x, has_aux=True)
        rows = lambda tree: ravel_pytree(tree)[0]  # noqa: E731
        J = jax.vmap(lambda t: rows(push(t)), out_axes=1)(jnp.eye(x.size, dtype=x.dtype))
        r = rows(r)
        cost = jnp.where(jnp.isfinite(r).all(), jnp.sum(r**2), jnp.inf)
        first = ~jnp.isfinite(state.cost)
        better = cost < state.cost
        kept = lambda new, old: jax.tree.map(lambda a, b: jnp.where(better, a, b), new, old)  # noqa: E731
        drop = state.cost - cost
        damping = jnp.where(first, state.damping, self._damping(state, drop, better))
        g, H = kept((J.T @ r, J.T @ J), (state.g, state.H))
        y, aux, lowest = kept((state.y_eval, aux, cost), (y, state.aux, state.cost))
        enough = jnp.maximum(self.atol, self.rtol * lowest)
        _, most = damped_step(g, H, jnp.zeros_like(damping))
        du, promise = damped_step(g, H, damping)
        small = better & ~first & (drop < enough) & (damping < 1.0)
        kink = ~better & ((most < ROUGH * enough) | (damping > MOST))
        end = (most < enough) | small | kink
        here, _ = ravel_pytree(y)
        return y, _State(g, H, lowest, aux, unravel(here + du), promise, damping, ~better, end), aux

    def terminate(self, fn, y, args, options, state, tags) -> tuple[Bool[Array, ""], Any]:  # noqa: ARG002
        lost = state.end & ~jnp.isfinite(state.cost)  # the first point was none
        result = optx.RESULTS.where(lost, optx.RESULTS.nonfinite, optx.RESULTS.successful)
        return state.end, result

    def postprocess(self, fn, y, aux, args, options, state, tags, result):  # noqa: ARG002
        return y, aux, {"sum_of_squares": state.cost}

    def _damping(self, state: _State, drop: Scalar, better: Bool[Array, ""]) -> Scalar:
        """Computes the damping of the next step, by how much of its promise the last one kept."""
        gain = drop / jnp.maximum(state.promise, jnp.finfo(drop.dtype).tiny)
        less = state.damping * jnp.where(gain > 0.7, 0.1, 0.5)
        less = jnp.where(state.refused, state.damping, jnp.maximum(less, LEAST))
        accepted = jnp.where(gain < 0.3, 3.0 * state.damping, less)
        return jnp.where(better, accepted, 10.0 * jnp.maximum(state.damping, FIRST))


def damped_step(
    g: Float[Array, " u"], H: Float[Array, "u u"], damping: Scalar
) -> tuple[Float[Array, " u"], Scalar]:
    """The step (u,) that minimises 2 g'du + du'(H + damping diag H) du, and the drop of the sum of
    squares that it promises.

    Args:
        g: half the gradient of the sum of squares. H: its Gauss-Newton matrix.
        damping: relative, of Levenberg and Marquardt.
    """
    diagonal = jnp.diagonal(H)
    tiny = jnp.finfo(H.dtype).tiny
    scale = jnp.sqrt(jnp.maximum(diagonal, jnp.maximum(1e-12 * diagonal.max(), tiny)))
    values, vectors = jnp.linalg.eigh(H / jnp.outer(scale, scale) + damping * jnp.eye(g.size))
    values = jnp.maximum(values, RANK * jnp.maximum(values[-1], tiny))
    du = -(vectors @ ((vectors.T @ (g / scale)) / values)) / scale
    return du, -(2.0 * g @ du + du @ H @ du)
