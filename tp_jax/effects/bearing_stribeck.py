"""The bearing's dry friction drops as it starts to move."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape


class BearingStribeck(Effect):
    """`M1 S (1 + a exp(-(v1 / vs)^2))`"""

    id = "bearing_stribeck"
    location = "bearing"
    hook = "bearing"
    amplitudes = (Amplitude("a", "1", typical=0.3, lower=-1.0),)
    shapes = (Shape("vs", "rad/s", (0.1, 0.3, 1.0, 3.0), continuous=True),)
    formula = "M1 S (1 + a exp(-(v1 / vs)^2))"
    source = "Stribeck (1902); Armstrong-Helouvry (1991)"
    looks_like = "an error around each reversal of the column"
    remedy = "clean the bearing and change its grease"
    by_hand = (
        "start the column from rest with a small weight on a thread, and see whether it runs on "
        "with less"
    )

    def increment(self, m, a, vs):  # type: ignore[override]
        """See the class."""
        return m.bearing_dry * a * jnp.exp(-((m.v1 / vs) ** 2))
