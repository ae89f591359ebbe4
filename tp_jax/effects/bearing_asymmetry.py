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
    remedy = "clean or replace the bearing, and take away the seal or burr that drags one way"
    by_hand = "turn the column slowly both ways by hand, and feel in which sense it is harder"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.M1 * jnp.abs(m.sign1)
