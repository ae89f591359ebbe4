"""The linearly implicit method as a diffrax solver.

The friction of a stuck body is stiff (about Ts1 (2/pi) eps (1/B1 + 1/B2): 1e6 1/s on the bench),
so explicit steps are limited by it. Here each stage needs one linear solve; positions follow
velocities, so that it comes down to a 2x2 system in closed form.
"""

from collections.abc import Callable
from typing import ClassVar

import diffrax
import jax
import jax.numpy as jnp
from diffrax import RESULTS
from jaxtyping import Array, Float

from tp_jax.simulation.tableau import ROS34PW2


class Rosenbrock(diffrax.AbstractAdaptiveSolver):
    """ROS34PW2 for states (phi1, phi2, v1, v2, own states of effects...), one array.

    The vector field must be a `diffrax.ODETerm` of a pendulum's `vector_field`: the first two
    components' derivatives are proportional to the third and fourth.
    """

    term_structure: ClassVar = diffrax.ODETerm
    interpolation_cls: ClassVar[Callable] = diffrax.ThirdOrderHermitePolynomialInterpolation.from_k

    def order(self, terms):  # noqa: ARG002
        """Order of the method."""
        return ROS34PW2.order

    def init(self, terms, t0, t1, y0, args):  # noqa: ARG002
        """No state is carried between steps."""
        return None

    def func(self, terms, t0, y0, args):
        """The vector field."""
        return terms.vf(t0, y0, args)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):  # noqa: ARG002
        """One step; see `diffrax.AbstractSolver.step`."""
        h = t1 - t0
        field = lambda t, y: terms.vf(t, y, args)  # noqa: E731
        jacobian = jax.jacfwd(lambda y: field(t0, y))(y0)
        stages: list[Array] = []
        first = field(t0, y0)
        for i in range(4):
            a, g = ROS34PW2.a[i], ROS34PW2.g[i]
            y = y0 + h * sum((a[j] * stages[j] for j in range(i) if a[j]), jnp.zeros_like(y0))
            rhs = first if i == 0 else field(t0 + ROS34PW2.c[i] * h, y)
            carried = sum((g[j] * stages[j] for j in range(i) if g[j]), jnp.zeros_like(y0))
            stages.append(solve_stage(jacobian, ROS34PW2.gamma * h, rhs + h * (jacobian @ carried)))
        y1 = y0 + h * sum(b * k for b, k in zip(ROS34PW2.b, stages, strict=True))
        error = h * sum(b * k for b, k in zip(ROS34PW2.b_error, stages, strict=True))
        k = jnp.stack([h * first, h * field(t1, y1)])
        dense = dict(y0=y0, y1=y1, k=k)
        return y1, error, dense, None, RESULTS.successful


def solve_stage(
    jacobian: Float[Array, "n n"], gh: Float[Array, ""], rhs: Float[Array, " n"]
) -> Float[Array, " n"]:
    """Solves `(I - gh J) k = rhs`.

    Four states: positions are eliminated (their rows are `c` times a velocity), which leaves 2x2
    in closed form. More states: a dense solve, since effects may couple anything.
    """
    if rhs.size > 4:
        return jnp.linalg.solve(jnp.eye(rhs.size) - gh * jacobian, rhs)
    rate = jacobian[0, 2]
    jq, jv = jacobian[2:, :2], jacobian[2:, 2:]
    rq, rv = rhs[:2], rhs[2:]
    w = jnp.eye(2) - gh * jv - gh**2 * rate * jq
    r = rv + gh * (jq @ rq)
    det = w[0, 0] * w[1, 1] - w[0, 1] * w[1, 0]
    kv = jnp.stack([w[1, 1] * r[0] - w[0, 1] * r[1], w[0, 0] * r[1] - w[1, 0] * r[0]]) / det
    return jnp.concatenate([rq + gh * rate * kv, kv])
