"""The torsion spring between the drive and the column."""

import equinox as eqx
from jaxtyping import Array, Float

from tp_jax.model.arrays import Real, as_float


class LinearSpring(eqx.Module):
    """Torque on the column `k d`, d = f_e - phi1 [rad], k [N m/rad]: left side of (16a)."""

    k: Float[Array, "..."] = eqx.field(converter=as_float)

    def torque(self, d: Real) -> Float[Array, "..."]:
        """Torque on the column [N m]."""
        return self.k * d

    def energy(self, d: Real) -> Float[Array, "..."]:
        """Stored energy [J]."""
        return 0.5 * self.k * d**2
