"""A rig without hidden effects, set going in mid-run from a state that another one was in."""

import math
from collections.abc import Sequence

import numpy as np

from tp_jax.rig.hooks import Hooks
from tp_jax.rig.motion import Motion
from tp_jax.rig.parameters import RigParameters

State = tuple[float, float, float, float]


def plain_window(
    parameters: RigParameters,
    omega: float | None,
    state: State,
    start: float,
    offsets: Sequence[float],
    phase: float = 0.0,
) -> np.ndarray:
    """Angles (n, 2) [rad] of a rig without effects after a restart.

    Args:
        parameters: its numbers.
        omega: of the drive [rad/s]; None: the motor stands at neutral.
        state: phi1, phi2 [rad], v1, v2 [rad/s] at the start.
        start: time of the run at which it starts [s].
        offsets: times since then [s], in order.
        phase: of the drive at t = 0 [rad].
    """
    A = parameters.A

    def arm(t: float) -> float:
        return 0.0 if omega is None else A * math.sin(omega * (start + t) + phase)

    phi1, phi2, v1, v2 = state
    motion = Motion(parameters, Hooks(), arm, phi1, v1=v1, v2=v2)
    segment = motion.step()
    angles = np.empty((len(offsets), 2))
    for i, t in enumerate(offsets):
        while motion.t < t:
            segment = motion.step()
        angles[i] = segment.read(t)[:2]
    # no torque of such a rig depends on where the rider is
    angles[:, 1] += phi2
    return angles
