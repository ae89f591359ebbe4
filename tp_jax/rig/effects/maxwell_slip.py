"""Hysteresis as a network of springs that slip: presliding, a cable, a spring's inner friction.

Elements i = 1..n side by side, each a spring of stiffness c in series with a slider that gives way
at a deflection of its own, delta_i:

    torque = sum_i c u_i,   u_i follows x within [-delta_i, delta_i]          (Maxwell slip, Iwan)

Deflections at the middle quantiles of an exponential distribution of mean z0 / 2, torque at full
slip scaled to 1. From a reversal at full slip the torque then falls as 1 - 2 (1 - exp(-x / z0)),
which is the branch of a Dahl state of length z0; between reversals below full slip the two differ
(the network closes its loops, Dahl's state drifts), and the virgin curve is twice as steep.

Sources: Iwan (1966), J. Appl. Mech. 33; Lampaert, Swevers, Al-Bender (2002), IEEE Trans. Autom.
Control 47; Dahl (1968) for the length.
"""

import math

ELEMENTS = 10
SLIPS = 1e-11  # rad: as near to its limit an element counts as slipping


class MaxwellSlip:
    """A network of `ELEMENTS`, torque between -1 and 1.

    Within a step x must go one way, which holds where steps end at its turning points; `begin`
    is to be called at the start of every step.
    """

    def __init__(self, length: float, x: float = 0.0):
        """A network without tension at deflection `x` [rad], of length z0 [rad]."""
        n = ELEMENTS
        self._limits = tuple(-0.5 * length * math.log1p(-(i + 0.5) / n) for i in range(n))
        self._stiffness = 1.0 / sum(self._limits)
        self._x = x
        self._u = [0.0] * n
        self._up = self._down = min(self._limits)

    def torque(self, x: float) -> float:
        """Torque at a deflection [rad] of the present step, of the torque at full slip."""
        way = x - self._x
        total = 0.0
        for u, limit in zip(self._u, self._limits, strict=True):
            u += way
            total += limit if u > limit else -limit if u < -limit else u
        return self._stiffness * total

    def to_kink(self, x: float) -> float:
        """Distance [rad] to where the next element begins to slip; below zero beyond."""
        way = x - self._x
        return min(self._up - way, self._down + way)

    def begin(self, x: float) -> None:
        """A step begins at deflection `x` [rad]."""
        way = x - self._x
        self._x = x
        self._u = [
            max(min(u + way, limit), -limit) for u, limit in zip(self._u, self._limits, strict=True)
        ]
        pairs = list(zip(self._u, self._limits, strict=True))
        # an element at its limit has no kink ahead while x goes on that way
        self._up = min((b - u for u, b in pairs if b - u > SLIPS), default=math.inf)
        self._down = min((b + u for u, b in pairs if b + u > SLIPS), default=math.inf)
