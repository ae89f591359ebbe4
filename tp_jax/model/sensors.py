"""The two angle sensors: zero offsets only; everything else about them is an effect."""

import equinox as eqx
from jaxtyping import Array, Float

from tp_jax.model.arrays import as_float


class Sensors(eqx.Module):
    """`y1 = phi1 + zero1`, `y2 = phi2 + zero2` [rad]."""

    zero1: Float[Array, "..."] = eqx.field(converter=as_float, default=0.0)
    zero2: Float[Array, "..."] = eqx.field(converter=as_float, default=0.0)
