"""The spring hardens or softens with its deflection."""

from tp_jax.effects.base import Amplitude, Effect


class SpringHardening(Effect):
    """`k (d + a d^3)`"""

    id = "spring_hardening"
    location = "spring"
    hook = "spring"
    amplitudes = (Amplitude("a", "1/rad^2", typical=0.1),)
    uses_winding = True
    formula = "k (d + a d^3)"
    source = "Section 6 of the paper"
    looks_like = "the natural frequency depends on the amplitude"
    remedy = "keep to small angles, or use a longer spring"
    by_hand = (
        "hang growing weights on a thread round the column, and see whether torque over angle bends"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.k * a * m.d**3
