"""Beyond some angle the column runs against a spring: a stop, a lead that is too short.

The two sides have stiffnesses of their own, either of which may be zero, and one angle. Where the
column never gets that far, nothing can be said of them.
"""

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape


class ElasticStop(Effect):
    """`-a (phi1 - s) for phi1 > s, -b (phi1 + s) for phi1 < -s`"""

    id = "elastic_stop"
    location = "column"
    hook = "column"
    amplitudes = (
        Amplitude("a", "N m/rad", typical=0.2, lower=0.0, upper=100.0),
        Amplitude("b", "N m/rad", typical=0.2, lower=0.0, upper=100.0),
    )
    shapes = (Shape("s", "rad", (0.05, 0.1, 0.2, 0.4, 0.8), continuous=True),)
    uses_phi1 = True
    formula = "-a (phi1 - s) for phi1 > s, -b (phi1 + s) for phi1 < -s"
    source = "elastic barriers: Nonlinear Dynamics (2020), doi 10.1007/s11071-020-05684-6"
    looks_like = "large swings that turn back too soon, and faster than small ones"
    remedy = "take away what the column touches, or drive it less far"
    by_hand = "turn the column by hand as far as it goes, and look for what it runs against"

    def increment(self, m, a, b, s):  # type: ignore[override]
        """See the class."""
        return b * jnp.maximum(-m.phi1 - s, 0.0) - a * jnp.maximum(m.phi1 - s, 0.0)
