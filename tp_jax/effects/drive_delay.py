"""The recorded drive is late: what is read at t, the spring's end did `a` seconds before.

    reading(t) = f_e(t - a) / gain,    f_e(t) = gain * reading(t + a)

so that a > 0 is a drive that is recorded late, as with `channel_delay`; a < 0 one that is recorded
early, which is a delay of both angles.

The curve between the samples is read at t + a itself (`AbstractDrive.later`), not continued from
t: there is no bound on the delay from that. What an estimation reads is that curve sampled anew
(`read_later` in `tp_jax.estimation.windows`), in error by (omega h)^4 / 200 of the drive's
amplitude for samples h apart, whatever the delay: less than 1e-4 from 17 samples a period on.
Beyond the ends of a recording, for the first or last |a| seconds, the drive goes on as a straight
line, which is in error by up to (omega a)^2 / 2.
"""

from tp_jax.effects.base import Amplitude, Effect


class DriveDelay(Effect):
    """`f_e(t) = gain reading(t + a)`"""

    id = "drive_delay"
    location = "clock"
    hook = "drive"
    amplitudes = (Amplitude("a", "s", typical=0.002, lower=-0.1, upper=0.1),)
    needs = frozenset({"measured"})
    reads_later = "a"
    formula = "f_e(t) = gain reading(t + a)"
    source = "filters, converters and cameras that read drive and angles one after the other"
    looks_like = "an error in the shape of the drive's velocity"
    remedy = "record the drive with the same clock and filter as the angles"
    by_hand = "knock against the arm, and compare when the drive and phi1 show it"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return m.later(a)
