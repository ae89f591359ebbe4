"""The sensor's cable holds the column back elastically, then slips.

A cable that is bent to and fro rubs inside: stiffness a at first, a torque of at most a z0. It is
without tension where a run begins. Where a window begins, z follows from the column's past path
(`past`).
"""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.dahl import dahl_along, dahl_rate


class ColumnCable(Effect):
    """`-a z, z' = v1 - |v1| z / z0`"""

    id = "column_cable"
    location = "column"
    hook = "column"
    amplitudes = (Amplitude("a", "N m/rad", typical=0.03, lower=0.0),)
    shapes = (Shape("z0", "rad", (0.05, 0.15, 0.5), continuous=True),)
    n_states = 1
    formula = "-a z, z' = v1 - |v1| z / z0"
    source = "Dahl (1968) for the law; Foti, Martinelli (2016) for bent cables"
    looks_like = "a stiffer column in small swings, more damping in large ones"
    remedy = "hang the sensor's cable free along the axis, or use a thinner one"
    by_hand = "time small swings with the cable on and taken off"

    def increment(self, m, a, z0):  # type: ignore[override]  # noqa: ARG002
        """See the class."""
        return -a * m.z[0]

    def rates(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_rate(m.v1, m.z[0], z0),)

    def past(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_along(m.phi1, z0),)
