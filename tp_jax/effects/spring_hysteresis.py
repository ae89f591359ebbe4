"""The spring's torque differs between loading and unloading.

Coils or clamps that rub: beside the spring stands one of stiffness a k that slips at z0. Where d
goes to and fro between -D and D, each turn takes the energy 4 a k z0 (D - z0 tanh(D / z0)),
whatever the speed.

Where a window begins, z follows from the past of d = f_e - phi1 (`past`): of the column's angle
and the drive's.
"""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.dahl import dahl_along, dahl_rate


class SpringHysteresis(Effect):
    """`k (d + a z), z' = d' - |d'| z / z0`"""

    id = "spring_hysteresis"
    location = "spring"
    hook = "spring"
    amplitudes = (Amplitude("a", "1", typical=0.1, lower=0.0, upper=1.0),)
    shapes = (Shape("z0", "rad", (0.03, 0.1, 0.3), continuous=True),)
    n_states = 1
    formula = "k (d + a z), z' = d' - |d'| z / z0"
    source = "Section 6 of the paper; Dahl (1968) for the law"
    looks_like = "damping that does not depend on speed, and acts even where the bearing is stuck"
    remedy = "clamp the spring's ends without rubbing, or change its material"
    by_hand = "load and unload the spring with the same weights, and compare the angles"

    def increment(self, m, a, z0):  # type: ignore[override]  # noqa: ARG002
        """See the class."""
        return m.k * a * m.z[0]

    def rates(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_rate(m.f_rate() - m.v1, m.z[0], z0),)

    def past(self, m, z0, **_):  # type: ignore[override]
        """See the class."""
        return (dahl_along(m.d, z0),)
