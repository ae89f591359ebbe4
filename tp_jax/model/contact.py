"""Friction between the column's head and the rider, equation (6)."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import Real, as_float
from tp_jax.model.friction import rising_sign, smooth_sign


class Contact(eqx.Module):
    """M_T of equation (6), against the rider's motion relative to the column.

    Fields: Tv [N m s/rad]; Ts1, Ts2, Tst [N m]; T0 [s/rad]; eps [s].

    Ts2 acts only where v2 = 0 exactly, in the same direction for either sense of motion: a set of
    no duration. `torque` therefore leaves it out; `printed_torque` keeps it, so that the law can
    be compared with the paper term by term.
    """

    Tv: Float[Array, "..."] = eqx.field(converter=as_float)
    Ts1: Float[Array, "..."] = eqx.field(converter=as_float)
    Tst: Float[Array, "..."] = eqx.field(converter=as_float)
    T0: Float[Array, "..."] = eqx.field(converter=as_float)
    eps: Float[Array, "..."] = eqx.field(converter=as_float)
    Ts2: Float[Array, "..."] = eqx.field(converter=as_float, default=0.0)

    def viscous(self, v: Real) -> Float[Array, "..."]:
        """Viscous part [N m]."""
        return self.Tv * v

    def dry(self, v: Real) -> Float[Array, "..."]:
        """Dry part [N m]: the smoothed Coulomb term and the one that rises with T0."""
        return self.Ts1 * smooth_sign(v, self.eps) + self.Tst * rising_sign(v, self.T0)

    def torque(self, v: Real) -> Float[Array, "..."]:
        """M_T without the Ts2 term [N m]."""
        return self.viscous(v) + self.dry(v)

    def printed_torque(self, v: Real) -> Float[Array, "..."]:
        """M_T as printed, with `Ts2 (1 - sgn |v|)` [N m]."""
        return self.torque(v) + self.Ts2 * (1.0 - jnp.sign(jnp.abs(v)))
