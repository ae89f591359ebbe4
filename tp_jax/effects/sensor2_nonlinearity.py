"""The bridge of sensor 2 is read with a straight line."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine


class Sensor2Nonlinearity(Effect):
    """`y2 = phi2 + a (sin(2 phi2) / 2 - phi2)`"""

    id = "sensor2_nonlinearity"
    location = "sensor2"
    hook = "sensor2"
    amplitudes = (Amplitude("a", "1", typical=0.3),)
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "y2 = phi2 + a (sin(2 phi2) / 2 - phi2)"
    source = "Section 6 of the paper; HMC1512: bridge voltage goes with sin(2 theta)"
    looks_like = "large angles read too small"
    remedy = "calibrate sensor 2 against known angles, as tp-jax calibrate does"
    by_hand = "turn the rider to five known angles, and compare the readings with a straight line"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * (0.5 * sine(2.0 * m.phi2) - m.phi2)
