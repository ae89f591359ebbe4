"""The bearing's friction drifts as it warms up."""

from tp_jax.effects.base import Amplitude, Effect, change_of_friction


class BearingWarmup(Effect):
    """`(M1 S + c1 v1)(1 + a s)`"""

    id = "bearing_warmup"
    location = "bearing"
    hook = "bearing"
    drifts = True
    amplitudes = (Amplitude("a", "1", typical=0.2, lower=-2.0, upper=2.0),)
    formula = "(M1 S + c1 v1)(1 + a s)"
    source = "Section 6 of the paper"
    looks_like = "too much damping at first, too little later"
    remedy = "let the rig run some minutes before recording, and keep the bearing's temperature"
    by_hand = "time the same decay with the rig cold and after half an hour of running"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return change_of_friction(a * m.s) * (m.bearing_dry + m.bearing_viscous)
