"""The motor and its arm: angle of the spring's far end."""

import math
from collections.abc import Callable

from tp_jax.rig.hooks import Hooks


def drive(A: float, omega: float | None, hooks: Hooks) -> Callable[[float], float]:
    """f_e(t) [rad], true time t [s]: A sin(omega t) and what effects make of it.

    Args:
        A: amplitude [rad]. omega: commanded frequency [rad/s]; None: the motor stands at neutral,
        whatever the effects.
    """
    sin = math.sin
    if omega is None:
        return lambda t: 0.0  # noqa: ARG005
    phases, angles = tuple(hooks.phase), tuple(hooks.drive)
    turns = omega + hooks.detuning
    if not phases and not angles:
        return lambda t: A * sin(turns * t)

    def angle(t):
        theta = turns * t
        for change in phases:
            theta = change(theta, t)
        f = A * sin(theta)
        for change in angles:
            f = change(f, theta)
        return f

    return angle
