"""The second channel is sampled later than the first."""

from tp_jax.effects.base import Amplitude, Effect


class ChannelDelay(Effect):
    """`y2(t) = phi2(t - a)`"""

    id = "channel_delay"
    location = "clock"
    hook = "sensor2"
    amplitudes = (Amplitude("a", "s", typical=0.002),)
    needs = frozenset({"rider"})
    formula = "y2(t) = phi2(t - a)"
    source = "two readings one after the other by one converter"
    looks_like = "an error in the shape of the rider's velocity"
    remedy = "read both sensors at one instant, or give each its own time stamp and the same filter"
    by_hand = "fix the rider to the column, swing both, and compare when the two readings turn"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return -a * m.v2 + 0.5 * a**2 * m.a2
