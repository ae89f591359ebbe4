"""The disc of sensor 1 sits off its axis."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine_cosine


class Sensor1Eccentricity(Effect):
    """`y1 = phi1 + a sin phi1 + b (cos phi1 - 1)`"""

    id = "sensor1_eccentricity"
    location = "sensor1"
    hook = "sensor1"
    # the disc's offset over the radius at which it is read
    amplitudes = (
        Amplitude("a", "rad", typical=0.02, lower=-0.5, upper=0.5),
        Amplitude("b", "rad", typical=0.02, lower=-0.5, upper=0.5),
    )
    uses_phi1 = True
    formula = "y1 = phi1 + a sin phi1 + b (cos phi1 - 1)"
    source = "one reading head on a disc or magnet off its axis: an error of one period a turn"
    looks_like = "readings too large on one side of the turn and too small on the other"
    remedy = "centre the disc of sensor 1 on its axis, or put a second reading head opposite"
    by_hand = "turn the column by quarters of a turn against a protractor, and compare the readings"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(m.phi1)
        return a * s + b * (c - 1.0)
