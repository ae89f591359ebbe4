"""The spring's stiffness drifts within a recording."""

from tp_jax.effects.base import Amplitude, Effect


class SpringRelaxation(Effect):
    """`k d (1 + a s)`"""

    id = "spring_relaxation"
    location = "spring"
    hook = "spring"
    drifts = True
    amplitudes = (Amplitude("a", "1", typical=0.05),)
    formula = "k d (1 + a s)"
    source = "Section 6 of the paper"
    looks_like = "an error that changes sign in the middle of a recording"
    remedy = "wind the spring for an hour before recording, and keep its temperature"
    by_hand = (
        "hang one weight on a thread round the column for an hour, and see whether the angle creeps"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.k * a * m.s * m.d
