"""The column vibrates vertically, so that the normal force oscillates."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape, change_of_friction
from tp_jax.model.elementary import sine_cosine


class ContactVibration(Effect):
    """`(Ts1 S + Tst term)(1 + a_r cos W t + b_r sin W t)`"""

    id = "contact_vibration"
    location = "contact"
    hook = "contact"
    amplitudes = (
        Amplitude("a", "1", typical=0.2, lower=-1.0, upper=1.0, per_recording=True),
        Amplitude("b", "1", typical=0.2, lower=-1.0, upper=1.0, per_recording=True),
    )
    shapes = (Shape("W", "Hz", (3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0), continuous=True),)
    needs = frozenset({"rider"})
    formula = "(Ts1 S + Tst term)(1 + a_r cos W t + b_r sin W t)"
    source = "Section 6 of the paper"
    looks_like = "ripple of the friction at a fixed frequency"
    remedy = "balance the motor, and decouple it from the column"
    by_hand = "feel the column for vertical vibration with the motor on and off"

    def increment(self, m, a, b, W):  # type: ignore[override]
        """See the class."""
        s, c = sine_cosine(2.0 * jnp.pi * W * m.t)
        return m.contact_dry * change_of_friction(a * c + b * s)
