"""The bearing's dry friction grows with the load that the spring puts on it."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class BearingLoad(Effect):
    """`M1 S (1 + a |T_spring| / M1)`"""

    id = "bearing_load"
    location = "bearing"
    hook = "bearing"
    # At one, friction takes all of the spring's torque, and the column never moves.
    amplitudes = (Amplitude("a", "1", typical=0.05, lower=0.0, upper=1.0),)
    formula = "M1 S (1 + a |T_spring| / M1)"
    source = (
        "friction of gears under load: Duclusaud, Passault, Padois, Ly (2024), arXiv 2410.08650, "
        "models M3 to M6 (M3 has Kl |load|)"
    )
    looks_like = "too little friction where the spring is wound, and damping at all amplitudes"
    remedy = (
        "relieve the bearing of side load: align the spring with the axis, or use a larger bearing"
    )
    by_hand = (
        "turn the column by hand with the spring off its hook and on it, and feel what the load "
        "adds"
    )

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * jnp.abs(m.spring) * m.sign1
