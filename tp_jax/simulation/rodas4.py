"""RODAS4 as a diffrax solver: the step that the batch engine takes, in anybody's `diffeqsolve`.

The friction of a stuck body is stiff (about Ts1 (2/pi) eps (1/B1 + 1/B2): 1e6 1/s on the bench), so
that the steps of explicit methods are limited by it. Here each stage needs one linear solve;
positions follow velocities, so that it comes down to a 2x2 system in closed form
(`tp_jax.simulation.linear_solve`).
"""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from diffrax import RESULTS
from jaxtyping import Array

from tp_jax.simulation.step import Structure, advance, between
from tp_jax.simulation.tableau import RODAS4

NO_STEP = 1e-6
"""Length [s] of a step that nobody takes."""


def components(y: Any) -> list[Array]:
    """Components () of a state: a tuple of them, or one array (n,)."""
    return list(y) if isinstance(y, tuple | list) else [y[i] for i in range(y.shape[0])]


def together(found: Sequence[Array], like: Any) -> Any:
    """Components as a state of the kind of `like`."""
    return type(like)(found) if isinstance(like, tuple | list) else jnp.stack(list(found))


class QuinticInterpolation(diffrax.AbstractLocalInterpolation):
    """Motion inside a step: angles by quintic Hermite interpolation, velocities as their slope.

    Attributes:
        t0, t1: ends of the step [s].
        y0, y1: states there; f0, f1: their derivatives, tuples of ().
        rate: true seconds per recorded second.
    """

    t0: Array
    t1: Array
    y0: Any
    y1: Any
    f0: tuple
    f1: tuple
    rate: Array

    def evaluate(self, t0, t1=None, left: bool = True):  # noqa: ARG002
        """State at `t0`, or its change from `t0` to `t1`."""
        if t1 is not None:
            return jax.tree.map(jnp.subtract, self.evaluate(t1), self.evaluate(t0))
        h = self.t1 - self.t0
        length = jnp.where(h == 0.0, 1.0, h)  # what an empty step holds is its beginning
        x = (t0 - self.t0) / length
        y0, y1 = components(self.y0), components(self.y1)
        found = between([x], length, y0, list(self.f0), y1, list(self.f1), self.rate, True)[0]
        found += [a + x * (b - a) for a, b in zip(y0[4:], y1[4:], strict=True)]
        return together(
            [jnp.where(h == 0.0, a, b) for a, b in zip(y0, found, strict=True)], self.y0
        )


class Rodas4(diffrax.AbstractAdaptiveSolver):
    """RODAS4 (Hairer and Wanner 1996, section IV.7): order 4, embedded order 3, L-stable.

    For pendulums: the term is a `diffrax.ODETerm` of their `vector_field`, or of `derivative` on
    tuples, which is faster. A state is (phi1, phi2, v1, v2, own states of effects...), of which the
    first two follow the next two. Use it with `ReversalController`; another step size controller
    learns of a reversal by failing.

    Example:
        >>> import diffrax, numpy as np, tp_jax as tp
        >>> bench = tp.presets.get("bench")
        >>> found = diffrax.diffeqsolve(
        ...     diffrax.ODETerm(bench.vector_field), tp.Rodas4(), 0.0, 1.0, 1e-4, np.zeros(4),
        ...     stepsize_controller=tp.ReversalController(bench), max_steps=10_000,
        ... )
        >>> found.ys.shape
        (1, 4)
    """

    term_structure: ClassVar = diffrax.ODETerm
    interpolation_cls: ClassVar[Callable[..., QuinticInterpolation]] = QuinticInterpolation

    def order(self, terms):  # noqa: ARG002
        """Order of the method."""
        return RODAS4.order

    def init(self, terms, t0, t1, y0, args):
        """Derivatives of the state at the start; each step hands on those at its end."""
        return _field(terms, t0, t1, y0, args)(t0, components(y0))

    def func(self, terms, t0, y0, args):
        """The vector field."""
        return terms.vf(t0, y0, args)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """One step; see `diffrax.AbstractSolver.step`."""
        field = _field(terms, t0, t1, y0, args)
        # Beside runs that go on, one that has ended takes steps of no length, and none of what they
        # give: but a quotient by zero would make its gradient NaN all the same.
        y, h = components(y0), jnp.where(t1 > t0, t1 - t0, NO_STEP)
        if made_jump is False:
            f = solver_state
        else:
            f = jax.lax.cond(
                made_jump, lambda: self.init(terms, t0, t1, y0, args), lambda: solver_state
            )
        done = advance(field, pendular(len(y)), RODAS4, t0, h, y, list(f), ())
        error = together(done.error, y0)
        end = together(done.y, y0)
        dense = dict(y0=y0, y1=end, f0=tuple(f), f1=tuple(done.f), rate=done.jacobian[0][2])
        return end, error, dense, tuple(done.f), RESULTS.successful


def _field(terms, t0, t1, like: Any, args: Any) -> Callable[..., tuple]:
    """Derivatives of the state by the time that diffrax steps in, which always grows."""
    direction = jnp.where(terms.contr(t0, t1) < 0.0, -1.0, 1.0)  # of no length: forwards

    def field(t, y, p=()):  # noqa: ARG001
        return tuple(direction * x for x in components(terms.vf(t, together(y, like), args)))

    return field


def pendular(n: int) -> Structure:
    """Lets all in a pendulum of n states depend on all, but angles on velocities only."""
    by_state = np.ones((n, n), bool)
    by_state[:2] = False
    by_state[0, 2] = by_state[1, 3] = True
    return Structure(by_state, np.ones(n, bool))
