"""Cam and arm do not make a pure sine."""

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine_cosine


class DriveHarmonics(Effect):
    """`f = A (sin theta + a sin 2 theta + b (cos 2 theta - 1))`"""

    id = "drive_harmonics"
    location = "drive"
    hook = "drive"
    amplitudes = (
        Amplitude("a", "1", typical=0.05),
        Amplitude("b", "1", typical=0.05),
    )
    needs = frozenset({"sine"})
    formula = "f = A (sin theta + a sin 2 theta + b (cos 2 theta - 1))"
    source = "Section 6 of the paper"
    looks_like = "a second harmonic of the drive in both angles"
    remedy = "lengthen the connecting rod, or measure the arm's angle and give it as drive"
    by_hand = (
        "turn the motor by hand in steps of 30 degrees, note the arm's angle, and compare with a "
        "sine"
    )

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(2.0 * m.theta)
        return m.A * (a * s + b * (c - 1.0))
