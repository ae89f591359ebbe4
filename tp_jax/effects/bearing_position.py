"""The bearing's dry friction depends on its angle."""

from tp_jax.effects.base import Amplitude, Effect, Shape, change_of_friction
from tp_jax.model.elementary import sine_cosine


class BearingPosition(Effect):
    """`M1 S (1 + a cos n phi1 + b sin n phi1)`"""

    id = "bearing_position"
    location = "bearing"
    hook = "bearing"
    amplitudes = (
        Amplitude("a", "1", typical=0.2, lower=-1.0, upper=1.0),
        Amplitude("b", "1", typical=0.2, lower=-1.0, upper=1.0),
    )
    shapes = (Shape("n", "1", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)),)
    formula = "M1 S (1 + a cos n phi1 + b sin n phi1)"
    source = "Section 6 of the paper"
    looks_like = "an error tied to the column's angle, with the sign of its velocity"
    remedy = "clean the bearing, or mount it anew without strain"
    by_hand = "turn the column slowly once around, and feel at which angles it is stiff"

    def increment(self, m, a, b, n):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(n * m.phi1)
        return m.bearing_dry * change_of_friction(a * c + b * s)
