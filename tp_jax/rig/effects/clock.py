"""Times at which samples are taken, and at which they are said to have been."""

from tp_jax.rig.effects.base import Effect


class ChannelDelay(Effect):
    """The converter reads the rider's sensor later than the column's, or earlier."""

    id = "channel_delay"
    formula = "y2(t) = phi2(t - a)"
    unit = ("s",)
    channel = location = "clock"
    needs_rider = True

    def install(self, run, a):
        run.hooks.delay += a

    def drawn(self, dice):
        return self._drawn(dice.signed(0.001, 0.005))


class DriveDelay(Effect):
    """The drive is recorded late, or early. Shows only where it is recorded (`make_campaign`)."""

    id = "drive_delay"
    formula = "the drive recorded at t is that of t - a"
    unit = ("s",)
    channel = location = "clock"

    def install(self, run, a):
        run.hooks.drive_delay += a

    def drawn(self, dice):
        return self._drawn(dice.signed(0.002, 0.01))


class ClockSkew(Effect):
    """The recorder's oscillator runs fast or slow."""

    id = "clock_skew"
    formula = "recorded t = (1 + a) true t"
    channel = location = "clock"

    def install(self, run, a):
        run.hooks.stamps.append(lambda recorded: recorded / (1.0 + a))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.004, 0.02))
