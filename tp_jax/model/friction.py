"""Smoothed dry friction: the arctangent of equations (5) and (6)."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import Real
from tp_jax.model.elementary import arctan


def smooth_sign(v: Real, eps: Real) -> Float[Array, "..."]:
    """Smoothed sign of a velocity, `(2/pi) arctan(eps v)`.

    Args:
        v: velocity [rad/s].
        eps: slope of the smoothing [s]; numerical, not physical. A stuck body creeps with
            `tan(pi M / 2 M_max) / eps`.

    Source: Czerwinski, Olejnik, Awrejcewicz (2015), equation (5).
    """
    return (2.0 / jnp.pi) * arctan(eps * v)


def rising_sign(v: Real, rate: Real) -> Float[Array, "..."]:
    """`(1 - exp(-rate |v|)) sgn v`: dry friction that builds up with speed, zero at rest.

    Args:
        v: velocity [rad/s].
        rate: T0 of the paper [s/rad].

    Source: equation (6), last term. The paper calls it the Stribeck effect; for a positive
    coefficient it rises with speed, a Stribeck drop needs a negative one.
    """
    # `expm1` would keep more digits at tiny velocities, where this term is nothing beside the
    # smoothed sign; it costs twice as much.
    return (1.0 - jnp.exp(-rate * jnp.abs(v))) * jnp.sign(v)
