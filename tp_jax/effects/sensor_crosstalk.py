"""The rider's sensor also sees the column's angle."""

from tp_jax.effects.base import Amplitude, Effect


class SensorCrosstalk(Effect):
    """`y2 = phi2 + a phi1`"""

    id = "sensor_crosstalk"
    location = "sensor2"
    hook = "sensor2"
    amplitudes = (Amplitude("a", "1", typical=0.02),)
    needs = frozenset({"rider"})
    formula = "y2 = phi2 + a phi1"
    source = "two bridges near the same magnets"
    looks_like = "a stuck rider seems to move with the column"
    remedy = (
        'shield sensor 2 from the column, or write minus = "phi1" if it is measured against the '
        "base"
    )
    by_hand = "hold the rider fast to the column and turn both: phi2 must stay"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.phi1
