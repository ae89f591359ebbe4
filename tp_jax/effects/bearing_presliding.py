"""The bearing gives way elastically before it slides.

A part of the dry friction is carried by bristles, which bend over a path of z0 before they slip.
The part that is left is the baseline's, so that amplitude zero is the baseline and full amplitude
is Dahl's law alone; on the way the friction at full slip stays what it is.

Where a window begins, z follows from the column's past path, of which it forgets all but the last
few z0 (`past`). Noise is a path too, though one to nowhere: see `tp_jax.model.dahl`.
"""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.dahl import dahl_along, dahl_rate


class BearingPresliding(Effect):
    """`M1 ((1 - a) S + a z / z0), z' = v1 - |v1| z / z0`"""

    id = "bearing_presliding"
    location = "bearing"
    hook = "bearing"
    amplitudes = (Amplitude("a", "1", typical=0.5, lower=0.0, upper=1.0),)
    shapes = (Shape("z0", "rad", (0.001, 0.003, 0.01, 0.03), continuous=True),)
    n_states = 1
    formula = "M1 ((1 - a) S + a z / z0), z' = v1 - |v1| z / z0"
    source = "Dahl (1968); Armstrong-Helouvry, Dupont, Canudas de Wit (1994)"
    looks_like = "reversals of the column that are rounded, and a column that rings when it stops"
    remedy = "use a bearing with less grease or preload"
    by_hand = (
        "push the column lightly from rest without making it slide, and see whether it springs back"
    )

    def increment(self, m, a, z0):  # type: ignore[override]
        """See the class."""
        return a * (m.M1 * m.z[0] / z0 - m.bearing_dry)

    def rates(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_rate(m.v1, m.z[0], z0),)

    def past(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_along(m.phi1, z0),)
