"""The contact's dry friction drops as the rider starts to slide."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape


class ContactStribeck(Effect):
    """`(Ts1 S + Tst term)(1 + a exp(-(v2 / vs)^2))`"""

    id = "contact_stribeck"
    location = "contact"
    hook = "contact"
    amplitudes = (Amplitude("a", "1", typical=0.3, lower=-1.0),)
    shapes = (Shape("vs", "rad/s", (0.1, 0.3, 1.0, 3.0), continuous=True),)
    needs = frozenset({"rider"})
    formula = "(Ts1 S + Tst term)(1 + a exp(-(v2 / vs)^2))"
    source = "Stribeck (1902); Armstrong-Helouvry (1991)"
    looks_like = "the rider sticks longer, then slides further"
    remedy = "clean the contact's surfaces, or use a pad of PTFE, which has less friction at rest"
    by_hand = (
        "pull the rider slowly with a spring balance, and compare the force that starts it with "
        "the one that keeps it moving"
    )

    def increment(self, m, a, vs):  # type: ignore[override]
        """See the class."""
        return m.contact_dry * a * jnp.exp(-((m.v2 / vs) ** 2))
