"""The contact gives way elastically before the rider slides.

As in the bearing (`bearing_presliding`): a part of the dry terms is carried by bristles that bend
over a path of z0; how much they carry at full slip follows the speed as the dry terms do.

Where a window begins, z follows from the rider's past path on the column (`past`). A rider that
sticks keeps its z for as long as it sticks, while the noise of a measured angle would let it
forget: take the path from fitted motions where there are any; see `tp_jax.model.dahl`.
"""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.dahl import dahl_along, dahl_rate


class ContactPresliding(Effect):
    """`(1 - a)(Ts1 S + Tst term) + a (Ts1 + |Tst term|) z / z0, z' = v2 - |v2| z / z0`"""

    id = "contact_presliding"
    location = "contact"
    hook = "contact"
    amplitudes = (Amplitude("a", "1", typical=0.5, lower=0.0, upper=1.0),)
    shapes = (Shape("z0", "rad", (0.001, 0.003, 0.01, 0.03, 0.05), continuous=True),)
    needs = frozenset({"rider"})
    n_states = 1
    formula = "(1 - a)(Ts1 S + Tst term) + a (Ts1 + |Tst term|) z / z0, z' = v2 - |v2| z / z0"
    source = "Dahl (1968); Armstrong-Helouvry, Dupont, Canudas de Wit (1994)"
    looks_like = "a stuck rider that still moves a little, and rings when it stops"
    remedy = "use a stiffer or thinner contact pad"
    by_hand = "push the stuck rider lightly, and see whether it springs back when let go"

    def increment(self, m, a, z0):  # type: ignore[override]
        """See the class."""
        limit = m.Ts1 + jnp.abs(m.contact_dry - m.Ts1 * m.sign2)
        return a * (limit * m.z[0] / z0 - m.contact_dry)

    def rates(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_rate(m.v2, m.z[0], z0),)

    def past(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_along(m.phi2, z0),)
