"""The recorder's clock runs fast or slow."""

from tp_jax.effects.base import Amplitude, Effect


class ClockSkew(Effect):
    """`recorded t = (1 + a) true t`"""

    id = "clock_skew"
    location = "clock"
    hook = "clock"
    amplitudes = (Amplitude("a", "1", typical=0.01),)
    # readings of a drive have the recorder's own times, which no clock of the motor's contradicts
    needs = frozenset({"sine", "commanded"})
    formula = "recorded t = (1 + a) true t"
    source = "crystal oscillators, RC oscillators of small controllers"
    looks_like = "an error that grows with time in forced runs"
    remedy = "correct the recorder's sample rate to what another clock says"
    by_hand = "time a run of ten minutes with another clock, and compare with the last time stamp"

    def increment(self, m, a):  # type: ignore[override]  # noqa: ARG002
        """See the class."""
        return 1.0 / (1.0 + a) - 1.0
