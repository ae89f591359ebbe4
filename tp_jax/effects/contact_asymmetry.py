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
    remedy = "turn the contact's parts round or replace them, and set the rider square to its axis"
    by_hand = "slide the rider slowly both ways with a spring balance, and compare the two forces"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * jnp.abs(m.contact_dry)
