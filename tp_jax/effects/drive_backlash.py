"""A gap between motor and spring: the spring's end follows only once the gap is used up.

The play operator remembers, but of a sine it remembers the last turning point only, which is
known: no state is needed. Rising, the end stays at -(A - g) until f - g has come up to that;
falling likewise. (What a run does before its first turning point, at most a quarter of a turn, is
taken as if the sine had always been going on.)

To first order in g the end lags by g sgn(f'), but the way across the gap, 2 g after each turn,
takes a time in proportion to sqrt(g): a derivative at null would be that of no gap one can see.
Hence a gap below 0.025 A, which is next to none, is crossed like one of 0.025 A:

    f - g/L (f - play of half width L of f),    L^4 = g^4 + (0.025 A)^4

which is the play operator to 1 % of L from g = 0.06 A on, and has at null the direction of a gap
of 0.025 A. (Base parameters projected out, the direction of a gap of 0.04 A is met with a cosine
of 0.998 instead of 0.91; of one of 0.08 A with 0.95 instead of 0.78.)
"""

import math

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect
from tp_jax.model.elementary import sine

LEAST = 0.025
"""Half the least gap that takes its own time to cross, as a part of the drive's amplitude."""


class DriveBacklash(Effect):
    """`f = play of half width g of A sin theta`"""

    id = "drive_backlash"
    location = "drive"
    hook = "drive"
    amplitudes = (Amplitude("g", "rad", typical=0.01, lower=0.0, upper=0.2),)
    # A measured drive is either measured behind the gap, or it has no turning points known
    # beforehand: the operator would need the whole record.
    needs = frozenset({"sine"})
    formula = "f = play of half width g of A sin theta"
    source = "Krasnosel'skii, Pokrovskii (1989) for the operator; couplings and cams have play"
    looks_like = "a drive that is late and stands still for a while wherever it turns"
    remedy = "take the play out of the crank and its joints"
    by_hand = "turn the motor by hand to and fro, and see how far it turns before the arm moves"

    def increment(self, m, g):  # type: ignore[override]
        """See the class."""
        # a motor at rest (A = 0) stays where it is in its gap; nor may derivatives divide by it
        runs = m.A > 0.0
        A = jnp.where(runs, m.A, 1.0)
        half = jnp.sqrt(jnp.sqrt(g**4 + (LEAST * A) ** 4))
        f = A * sine(m.theta)
        reach = jnp.maximum(A - half, 0.0)
        rising = jnp.maximum(f - half, -reach)
        falling = jnp.minimum(f + half, reach)
        rises = sine(m.theta + 0.5 * math.pi) >= 0.0
        lag = jnp.where(rises, rising, falling) - f
        return jnp.where(runs, g / half * lag, 0.0)
