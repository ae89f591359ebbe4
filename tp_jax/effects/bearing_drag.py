"""Quadratic drag on the column."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class BearingDrag(Effect):
    """`a v1 |v1|`"""

    id = "bearing_drag"
    location = "bearing"
    hook = "bearing"
    amplitudes = (Amplitude("a", "N m s^2/rad^2", typical=0.0001),)
    formula = "a v1 |v1|"
    source = "air drag at higher speed"
    looks_like = "large swings decay faster than small ones"
    remedy = (
        "take large vanes or a damper off the column, shield it from air, or keep to low speeds"
    )
    by_hand = (
        "let the column swing widely with and without a shield, and time how long each takes to "
        "halve"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.v1 * jnp.abs(m.v1)
