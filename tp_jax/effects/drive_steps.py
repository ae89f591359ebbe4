"""The stepper motor moves in steps."""

import math

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape


class DriveSteps(Effect):
    """`theta + a (q round(theta / q) - theta)`"""

    id = "drive_steps"
    location = "drive"
    hook = "phase"
    amplitudes = (Amplitude("a", "1", typical=1.0, lower=-1.0, upper=1.0),)
    shapes = (Shape("q", "rad", (math.pi / 100, math.pi / 800, math.pi / 1600)),)
    needs = frozenset({"sine"})
    formula = "theta + a (q round(theta / q) - theta)"
    source = "stepper motors, 1.8 degrees a step and fractions"
    looks_like = "ripple at the step rate"
    remedy = "use microsteps, or a belt between motor and crank"
    by_hand = "run the motor slowly with the column held, and feel the arm for single steps"

    def increment(self, m, a, q):  # type: ignore[override]
        """See the class."""
        return a * (q * jnp.round(m.theta / q) - m.theta)

    def resolved(self, omega, step):
        """Two samples a step at least: what is faster is averaged by the pendulum, and aliased."""
        return omega * step <= 0.5 * max(self.shapes[0].grid)
