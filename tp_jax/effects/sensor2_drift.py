"""Gain and zero of sensor 2 drift within a recording."""

from tp_jax.effects.base import Amplitude, Effect


class Sensor2Drift(Effect):
    """`y2 = phi2 (1 + a s) + b s`"""

    id = "sensor2_drift"
    location = "sensor2"
    hook = "sensor2"
    drifts = True
    amplitudes = (
        Amplitude("a", "1", typical=0.05),
        Amplitude("b", "rad", typical=0.02),
    )
    needs = frozenset({"rider"})
    uses_phi2 = True
    formula = "y2 = phi2 (1 + a s) + b s"
    source = "temperature of the bridge amplifiers"
    looks_like = "readings that grow or wander with time, without a force"
    remedy = "let the electronics of sensor 2 warm up before recording"
    by_hand = "compare the reading of sensor 2 at rest before and after a run"

    def increment(self, m, a, b):  # type: ignore[override]
        """See the class."""
        return a * m.s * m.phi2 + b * m.s
