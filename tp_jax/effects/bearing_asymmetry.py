"""The bearing's dry friction differs between the two senses of rotation."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class BearingAsymmetry(Effect):
    """`M1 (S + a |S|)`"""

    id = "bearing_asymmetry"
    location = "bearing"
    hook = "bearing"
    amplitudes = (Amplitude("a", "1", typical=0.2, lower=-1.0, upper=1.0),)
    formula = "M1 (S + a |S|)"
    source = "Armstrong-Helouvry et al. (1994), Automatica 30"
    looks_like = "a constant torque while the column moves"
    remedy = (
        "turn the column slowly by hand both ways and feel for a seal or burr that drags "
        "one way; clean or replace the bearing"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.M1 * jnp.abs(m.sign1)
