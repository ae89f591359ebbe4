"""The contact's friction is not the same from run to run."""

from tp_jax.effects.base import Amplitude, Effect


class ContactRepeatability(Effect):
    """`Ts1 (1 + a_r), sum of a_r = 0`"""

    id = "contact_repeatability"
    location = "contact"
    hook = "contact"
    amplitudes = (Amplitude("a", "1", typical=0.1, lower=-1.0, upper=1.0, per_recording=True),)
    needs = frozenset({"rider", "several"})
    relative = "Ts1"
    formula = "Ts1 (1 + a_r), sum of a_r = 0"
    source = "Section 6 of the paper"
    looks_like = "each recording alone fits well, all together do not"
    remedy = "clean the contact before every run, and set the same normal force"
    by_hand = "repeat one setting five times, and compare how far the rider slides"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.Ts1 * m.sign2 * a
