"""The signals of sensor 1 are no clean sine and cosine, so that the angle between them is off."""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.elementary import sine_cosine


class Sensor1Interpolation(Effect):
    """`y1 = phi1 + a sin n phi1 + b (cos n phi1 - 1)`"""

    id = "sensor1_interpolation"
    location = "sensor1"
    hook = "sensor1"
    # beyond a quarter radian four waves a turn would no longer rise with the angle
    amplitudes = (
        Amplitude("a", "rad", typical=0.01, lower=-0.2, upper=0.2),
        Amplitude("b", "rad", typical=0.01, lower=-0.2, upper=0.2),
    )
    shapes = (Shape("n", "1", (2.0, 4.0)),)
    uses_phi1 = True
    formula = "y1 = phi1 + a sin n phi1 + b (cos n phi1 - 1)"
    source = (
        "Heydemann (1981), Applied Optics 20: of a magnetoresistive bridge, offsets of its two "
        "signals have n = 2, unlike sizes and a wrong phase between them n = 4"
    )
    looks_like = "an error that repeats within the turn, whatever the speed"
    remedy = "trim offset, gain and phase of the two signals of sensor 1, as tp-jax calibrate does"
    by_hand = (
        "turn the column slowly, and see whether the two signals plotted over each other make a "
        "circle"
    )

    def increment(self, m, a, b, n):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(n * m.phi1)
        return a * s + b * (c - 1.0)
