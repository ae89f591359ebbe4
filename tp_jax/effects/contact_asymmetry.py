"""The contact's dry friction differs between the two senses of sliding."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class ContactAsymmetry(Effect):
    """`(Ts1 + Tst term)(S + a |S|)`"""

    id = "contact_asymmetry"
    location = "contact"
    hook = "contact"
    amplitudes = (Amplitude("a", "1", typical=0.2, lower=-1.0, upper=1.0),)
    needs = frozenset({"rider"})
    formula = "(Ts1 + Tst term)(S + a |S|)"
    source = "Armstrong-Helouvry et al. (1994), Automatica 30"
    looks_like = "the rider creeps round in one direction"
    remedy = (
        "slide the rider slowly by hand both ways; turn the contact parts round and see "
        "whether the sense turns too"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * jnp.abs(m.contact_dry)
