"""Gravity on a mass off the column's axis."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class ColumnTilt(Effect):
    """`-(a sin phi1 + b cos phi1)`"""

    id = "column_tilt"
    location = "column"
    hook = "column"
    amplitudes = (
        Amplitude("a", "N m", typical=0.002),
        Amplitude("b", "N m", typical=0.002),
    )
    formula = "-(a sin phi1 + b cos phi1)"
    source = "Section 6 of the paper"
    looks_like = "a shifted rest position and a changed stiffness"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        return -(a * jnp.sin(m.phi1) + b * jnp.cos(m.phi1))
