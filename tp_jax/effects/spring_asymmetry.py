"""The spring is stiffer when wound than when unwound."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class SpringAsymmetry(Effect):
    """`k (d + a |d|)`"""

    id = "spring_asymmetry"
    location = "spring"
    hook = "spring"
    amplitudes = (Amplitude("a", "1", typical=0.05),)
    uses_winding = True
    formula = "k (d + a |d|)"
    source = "Section 6 of the paper"
    looks_like = "peaks of one sign larger than those of the other"
    remedy = "mount the spring without slack, or use two opposed springs"
    by_hand = "twist the spring by equal weights both ways, and compare the angles"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.k * a * jnp.abs(m.d)
