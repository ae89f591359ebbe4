"""There is play between the spring and its hook: near zero it pulls neither way."""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect


class SpringDeadzone(Effect):
    """`k (d - clip(d, -g, g))`"""

    id = "spring_deadzone"
    location = "drive"
    hook = "spring"
    amplitudes = (Amplitude("g", "rad", typical=0.01, lower=0.0, upper=0.2),)
    uses_winding = True
    formula = "k (d - clip(d, -g, g))"
    source = "a spring of three straight pieces, as couplings with clearance have"
    looks_like = "small swings that are slower than large ones, and no torque about the middle"
    remedy = "tighten the spring in its hook"
    by_hand = "turn the column by hand about its rest, and feel for play"

    def increment(self, m, g):  # type: ignore[override]
        """See the class."""
        # clip(d, -g, g), with the derivatives sign(d) by g at null and 1 by d at d = 0; within the
        # gap exactly -k d, lest rounding be a torque
        return -m.k * jnp.where(jnp.abs(m.d) <= g, m.d, jnp.sign(m.d) * g)
