"""Dahl's state: dry friction, or rubbing inside a solid, that gives way before it slips.

    z' = x' - |x'| z / z0        |z| <= z0

z [rad] is how far bristles are bent by the motion x. It follows x at first, and reaches +-z0 where
x goes on one way: after a reversal it changes sides over a path of about z0, whatever the speed.
|x'| has a kink where the motion turns. It is left: the state is smooth to first order there, and
an error estimate finds what is not, while a rounded kink would make the bristles creep.

Source: Dahl (1968), A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray, Real


def dahl_rate(rate: Real, z: Real, z0: Real) -> Float[AnyArray, "..."]:
    """z' [rad/s].

    Args:
        rate: x' [rad/s].
        z: state [rad].
        z0: path over which it forgets [rad].
    """
    return rate - jnp.abs(rate) * z / z0


@jax.jit
def dahl_along(
    x: Float[Array, " n"], z0: Float[Array, ""], start: Float[Array, ""] | float = 0.0
) -> Float[Array, " n"]:
    """The state [rad] along a path, going straight from each point to the next.

    Exact, however far apart the points are: only where the path turns matters, not when. So it
    may be taken along measured angles.

    Args:
        x: path [rad].
        z0: path over which it forgets [rad].
        start: state at the first point [rad].
    """
    step = jnp.diff(x)
    kept = jnp.exp(-jnp.abs(step) / z0)
    gained = jnp.sign(step) * z0 * (1.0 - kept)

    def go(z, change):
        z = change[0] * z + change[1]
        return z, z

    first = jnp.asarray(start, dtype=float)
    _, z = jax.lax.scan(go, first, (kept, gained))
    return jnp.concatenate([first[None], z])


@jax.jit
def play_along(x: Float[Array, " n"], half: Float[Array, ""] | float) -> Float[Array, " n"]:
    """Returns where a path goes beyond its noise: the play operator [rad], mid-gap at first.

    A body at rest whose angle is measured seems to wander, and a Dahl state taken along that would
    forget. Taken along the play of twice the angle's standard error it does not; where the body
    moves, the price is a lag of as much after each reversal.

    Args:
        x: path [rad].
        half: half the gap [rad].
    """

    def go(y, x):
        y = jnp.clip(y, x - half, x + half)
        return y, y

    return jax.lax.scan(go, x[0], x)[1]
