"""The torsion spring between the drive and the column."""

import equinox as eqx
from jaxtyping import Array, Float

from tp_jax.model.arrays import Real, as_float


class LinearSpring(eqx.Module):
    """Torque on the column `k d`, d = f_e - phi1 [rad], k [N m/rad]: left side of (16a).

    A constant torque that holds the column beside the angle at which the spring is relaxed is
    `k preload`: at rest the spring is wound by `preload` [rad]. Under a linear spring that is a
    zero of phi1, under another one it is not.
    """

    k: Float[Array, "..."] = eqx.field(converter=as_float)
    preload: Float[Array, "..."] = eqx.field(converter=as_float, default=0.0)

    def winding(self, turn: Real) -> Real:
        """Winding d of the spring [rad] where its end is `turn` [rad] ahead of the column."""
        return turn + self.preload

    def torque(self, d: Real) -> Float[Array, "..."]:
        """Torque on the column [N m], that of the preload taken off."""
        return self.k * (d - self.preload)

    def energy(self, d: Real) -> Float[Array, "..."]:
        """Stored energy [J]."""
        return 0.5 * self.k * d**2
