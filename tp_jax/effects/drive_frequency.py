"""The motor does not turn at the commanded speed."""

from tp_jax.effects.base import Amplitude, Effect


class DriveFrequency(Effect):
    """`theta = (omega_r + a_r) t`"""

    id = "drive_frequency"
    location = "drive"
    hook = "phase"
    amplitudes = (Amplitude("a", "rad/s", typical=0.05, per_recording=True),)
    needs = frozenset({"sine"})
    formula = "theta = (omega_r + a_r) t"
    source = "stepper drives: missed pulses, wrong clock"
    looks_like = "an error that grows with time within each forced run"
    remedy = (
        "write the omega that was counted, supply the motor with a steady voltage, or control its"
        " speed"
    )
    by_hand = "count the motor's turns in a minute, and compare with the commanded frequency"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.t
