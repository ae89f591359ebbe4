"""The bridge of sensor 1 is read with a straight line."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine


class Sensor1Nonlinearity(Effect):
    """`y1 = phi1 + a (sin(2 phi1) / 2 - phi1)`"""

    id = "sensor1_nonlinearity"
    location = "sensor1"
    hook = "sensor1"
    amplitudes = (Amplitude("a", "1", typical=0.3),)
    uses_phi1 = True
    formula = "y1 = phi1 + a (sin(2 phi1) / 2 - phi1)"
    source = "Section 6 of the paper; HMC1512: bridge voltage goes with sin(2 theta)"
    looks_like = "large angles read too small"
    remedy = "calibrate sensor 1 against known angles, as tp-jax calibrate does"
    by_hand = "turn the column to five known angles, and compare the readings with a straight line"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * (0.5 * sine(2.0 * m.phi1) - m.phi1)
