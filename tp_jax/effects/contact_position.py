"""The contact's dry friction depends on the rider's angle."""

from tp_jax.effects.base import Amplitude, Effect, Shape, change_of_friction
from tp_jax.model.elementary import sine_cosine


class ContactPosition(Effect):
    """`(Ts1 S + Tst term)(1 + a cos n phi2 + b sin n phi2)`"""

    id = "contact_position"
    location = "contact"
    hook = "contact"
    amplitudes = (
        Amplitude("a", "1", typical=0.2, lower=-1.0, upper=1.0),
        Amplitude("b", "1", typical=0.2, lower=-1.0, upper=1.0),
    )
    shapes = (Shape("n", "1", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)),)
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "(Ts1 S + Tst term)(1 + a cos n phi2 + b sin n phi2)"
    source = "Section 6 of the paper"
    looks_like = "the rider slides more easily at some angles"
    remedy = "clean, level or lap the contact's surfaces"
    by_hand = "slide the rider slowly once around, and look for marks where it is hard to move"

    def increment(self, m, a, b, n):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(n * m.phi2)
        return m.contact_dry * change_of_friction(a * c + b * s)
