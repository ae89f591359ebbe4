"""The contact's dry friction drifts within a recording."""

from tp_jax.effects.base import Amplitude, Effect, change_of_friction


class ContactWear(Effect):
    """`(Ts1 S + Tst term)(1 + a s)`"""

    id = "contact_wear"
    location = "contact"
    hook = "contact"
    drifts = True
    amplitudes = (Amplitude("a", "1", typical=0.2, lower=-2.0, upper=2.0),)
    needs = frozenset({"rider"})
    formula = "(Ts1 S + Tst term)(1 + a s)"
    source = "Section 6 of the paper"
    looks_like = "the rider slides less and less, or more and more"
    remedy = "run the contact in before recording, and wipe off what it has worn"
    by_hand = "repeat the first run at the end of the day, and compare how far the rider slides"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.contact_dry * change_of_friction(a * m.s)
