"""The disc of sensor 2 sits off its axis."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine_cosine


class Sensor2Eccentricity(Effect):
    """`y2 = phi2 + a sin phi2 + b (cos phi2 - 1)`"""

    id = "sensor2_eccentricity"
    location = "sensor2"
    hook = "sensor2"
    # the disc's offset over the radius at which it is read
    amplitudes = (
        Amplitude("a", "rad", typical=0.02, lower=-0.5, upper=0.5),
        Amplitude("b", "rad", typical=0.02, lower=-0.5, upper=0.5),
    )
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "y2 = phi2 + a sin phi2 + b (cos phi2 - 1)"
    source = "one reading head on a disc or magnet off its axis: an error of one period a turn"
    looks_like = "readings too large on one side of the turn and too small on the other"
    remedy = "centre the disc of sensor 2 on its axis, or put a second reading head opposite"
    by_hand = "turn the rider by quarters of a turn against a protractor, and compare the readings"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(m.phi2)
        return a * s + b * (c - 1.0)
