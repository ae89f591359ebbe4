"""Cam and arm do not make a pure sine."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class DriveHarmonics(Effect):
    """`f = A (sin theta + a sin 2 theta + b (cos 2 theta - 1))`"""

    id = "drive_harmonics"
    location = "drive"
    hook = "drive"
    amplitudes = (
        Amplitude("a", "1", typical=0.05),
        Amplitude("b", "1", typical=0.05),
    )
    needs = frozenset({"sine"})
    formula = "f = A (sin theta + a sin 2 theta + b (cos 2 theta - 1))"
    source = "Section 6 of the paper"
    looks_like = "a second harmonic of the drive in both angles"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        return m.A * (a * jnp.sin(2.0 * m.theta) + b * (jnp.cos(2.0 * m.theta) - 1.0))
