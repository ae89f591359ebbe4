"""Friction of the column's bearing, equation (5)."""

import equinox as eqx
from jaxtyping import Array, Float

from tp_jax.model.arrays import Real, as_float
from tp_jax.model.friction import smooth_sign


class Bearing(eqx.Module):
    """`M_L = c1 v1 + M1 (2/pi) arctan(eps v1)` against the column's motion.

    Fields: c1 [N m s/rad], M1 [N m], eps [s].
    """

    c1: Float[Array, "..."] = eqx.field(converter=as_float)
    M1: Float[Array, "..."] = eqx.field(converter=as_float)
    eps: Float[Array, "..."] = eqx.field(converter=as_float)

    def viscous(self, v: Real) -> Float[Array, "..."]:
        """Viscous part [N m]."""
        return self.c1 * v

    def dry(self, v: Real) -> Float[Array, "..."]:
        """Dry part [N m]."""
        return self.M1 * smooth_sign(v, self.eps)

    def torque(self, v: Real) -> Float[Array, "..."]:
        """M_L [N m]."""
        return self.viscous(v) + self.dry(v)
