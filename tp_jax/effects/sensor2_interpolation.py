"""The signals of sensor 2 are no clean sine and cosine, so that the angle between them is off."""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.elementary import sine_cosine


class Sensor2Interpolation(Effect):
    """`y2 = phi2 + a sin n phi2 + b (cos n phi2 - 1)`"""

    id = "sensor2_interpolation"
    location = "sensor2"
    hook = "sensor2"
    # beyond a quarter radian four waves a turn would no longer rise with the angle
    amplitudes = (
        Amplitude("a", "rad", typical=0.01, lower=-0.2, upper=0.2),
        Amplitude("b", "rad", typical=0.01, lower=-0.2, upper=0.2),
    )
    shapes = (Shape("n", "1", (2.0, 4.0)),)
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "y2 = phi2 + a sin n phi2 + b (cos n phi2 - 1)"
    source = (
        "Heydemann (1981), Applied Optics 20: of a magnetoresistive bridge, offsets of its two "
        "signals have n = 2, unlike sizes and a wrong phase between them n = 4"
    )
    looks_like = "an error that repeats within the turn, whatever the speed"
    remedy = "trim offset, gain and phase of the two signals of sensor 2, as tp-jax calibrate does"
    by_hand = (
        "turn the rider slowly, and see whether the two signals plotted over each other make a "
        "circle"
    )

    def increment(self, m, a, b, n):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(n * m.phi2)
        return a * s + b * (c - 1.0)
