"""Gain and zero of sensor 1 drift within a recording."""

from tp_jax.effects.base import Amplitude, Effect


class Sensor1Drift(Effect):
    """`y1 = phi1 (1 + a s) + b s`"""

    id = "sensor1_drift"
    location = "sensor1"
    hook = "sensor1"
    drifts = True
    amplitudes = (
        Amplitude("a", "1", typical=0.05),
        Amplitude("b", "rad", typical=0.02),
    )
    formula = "y1 = phi1 (1 + a s) + b s"
    source = "temperature of the bridge amplifiers"
    looks_like = "readings that grow or wander with time, without a force"
    remedy = "let the electronics of sensor 1 warm up before recording"
    by_hand = "compare the reading of sensor 1 at rest before and after a run"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        return a * m.s * m.phi1 + b * m.s
