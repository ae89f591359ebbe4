"""Gravity on a mass off the column's axis."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine_cosine


class ColumnTilt(Effect):
    """`-(a sin phi1 + b cos phi1)`"""

    id = "column_tilt"
    location = "column"
    hook = "column"
    amplitudes = (
        Amplitude("a", "N m", typical=0.002),
        Amplitude("b", "N m", typical=0.002),
    )
    formula = "-(a sin phi1 + b cos phi1)"
    source = "Section 6 of the paper"
    looks_like = "a shifted rest position and a changed stiffness"
    remedy = "set the column upright with a spirit level, and balance it with a counterweight"
    by_hand = "turn the whole rig by half a turn, and see whether the column rests at another angle"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(m.phi1)
        return -(a * s + b * c)
