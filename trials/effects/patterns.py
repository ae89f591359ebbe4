"""Shapes over angle and time that several cousins share."""

import math
from collections.abc import Callable

from tp_jax.rig.hooks import Instant

NEXT = 1e-9  # s: on an edge itself, the side on which the body is so much later decides


def settling(s: float, tau: float) -> float:
    """Rises from -1/2 to 1/2 over a run (s likewise), exponentially with `tau` of its length."""
    return math.expm1(-(s + 0.5) / tau) / math.expm1(-1.0 / tau) - 0.5


def bump(angle: float, centre: float, width: float) -> float:
    """1 at the centre, Gaussian, of standard deviation `width` [rad]."""
    return math.exp(-0.5 * ((angle - centre) / width) ** 2)


def saw(angle: float) -> float:
    """Rises from 0 to 1 at pi, from -1 on again: (angle / pi), by turns; 2 pi periodic."""
    turns = angle / (2.0 * math.pi)
    return 2.0 * (turns - math.floor(turns + 0.5))


class Side:
    """Side of a boundary on which a body is, with every step of the integration ending at it.

    What jumps there is constant in each step.
    """

    def __init__(self, hooks, level: Callable[[Instant, float], float]):
        """
        Args:
            hooks: of the run.
            level: (instant, time later [s]) -> what changes its sign at the boundary.
        """
        self.sign = 1.0
        self._level = level
        hooks.commits.append(self._commit)
        hooks.events.append(lambda m: level(m, 0.0))

    def _commit(self, m: Instant, _) -> None:
        self.sign = 1.0 if self._level(m, NEXT) >= 0.0 else -1.0
