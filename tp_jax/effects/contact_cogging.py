"""Magnets on the rider pull it to preferred angles."""

from tp_jax.effects.base import Amplitude, Effect, Shape
from tp_jax.model.elementary import sine_cosine


class ContactCogging(Effect):
    """`M_T + a sin n phi2 + b cos n phi2`"""

    id = "contact_cogging"
    location = "contact"
    hook = "contact"
    amplitudes = (
        Amplitude("a", "N m", typical=0.001),
        Amplitude("b", "N m", typical=0.001),
    )
    shapes = (Shape("n", "1", (1.0, 2.0, 3.0, 4.0)),)
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "M_T + a sin n phi2 + b cos n phi2"
    source = "the magnets of the rider's angle sensor, Section 2 of the paper"
    looks_like = "the rider prefers some angles, also when it is stuck"
    remedy = "take magnets and steel away from the rider"
    by_hand = "let the rider settle many times by hand, and note whether it prefers some angles"

    def increment(self, m, a, b, n):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(n * m.phi2)
        return a * s + b * c
