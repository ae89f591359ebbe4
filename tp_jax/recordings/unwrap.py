"""Following an angle beyond what a magnetoresistive sensor can tell by one reading.

Two bridges (sine_cosine) tell the angle modulo π: the branch next to the last angle is taken. After
a gap in which it may have gone anywhere, a column, which its spring holds, is on the branch about
zero; a ring is taken to be on the branch next to where it was, and that is counted as uncertain.

One bridge (sine) folds back at ±π/4 as well: θ and π/2 − θ give the same volts. There a filter
with the memory of some milliseconds is carried along, of angle, speed and acceleration. It listens
to a reading as far as the reading tells anything, which at the fold is nothing, so that it goes
through the fold by its own momentum, and its angle says which branch the reading is to be read on.
A motion that turns round near a fold cannot be told from one that goes through slowly: that is
counted as uncertain.
"""

import math

import numpy as np

LONGEST_CERTAIN = 0.05
"""Seconds without samples after which an angle may have gone to another branch unseen."""

MOVED = 0.05
"""Angle [rad] that must have been covered in them, at the last speed, for that."""

SLOW = 3.0
"""Speed [rad/s] at a fold below which the motion may as well turn round there."""

_LOOK_INSIDE = 0.01  # seconds without samples that make a gap, crossed by the speed before it
_MEMORY = 0.008  # seconds of the filter
_DEAF = 0.02  # squared slope of the reading, 1 in the middle, below which the filter listens less
_FOLD = 0.5 * math.pi  # between two folds


class Unwrapper:
    """Follows one angle through a recording.

    Attributes:
        uncertain: times [s] at which the branch was a guess.
    """

    def __init__(self, law: str, winds: bool = True) -> None:
        """
        Args:
            law: of the sensor's calibration.
            winds: whether the angle may go round and round; otherwise a spring holds it.
        """
        self.law, self.winds = law, winds
        self.uncertain: list[float] = []
        self._t: float | None = None
        self._angle = self._speed = self._acceleration = 0.0
        self._doubtful = False

    def feed(self, t: np.ndarray, principal: np.ndarray) -> np.ndarray:
        """(n,) angles for (n,) principal angles of the law at (n,) rising times."""
        if self.law == "line" or not t.size:
            return principal
        steps = np.diff(t)
        least = steps.min() if steps.size else 0.0
        breaks = np.flatnonzero(steps > max(_LOOK_INSIDE, 2.5 * least)) + 1
        parts = zip(np.split(t, breaks), np.split(principal, breaks), strict=True)
        return np.concatenate([self._piece(*part) for part in parts])

    def _piece(self, t: np.ndarray, principal: np.ndarray) -> np.ndarray:
        """Does what `feed` does, where there is no gap but before the first sample."""
        if self._t is not None and t[0] - self._t > LONGEST_CERTAIN:
            if not self.winds and self.law == "sine_cosine":
                self._angle = 0.0
            elif abs(self._speed) * (t[0] - self._t) > MOVED:
                self.uncertain.append(float(t[0]))
            self._speed = self._acceleration = 0.0
        if self.law == "sine":
            pairs = zip(t.tolist(), principal.tolist(), strict=True)
            return np.array([self._next(*pair) for pair in pairs])
        angle = np.unwrap(principal, period=np.pi)
        if self._t is not None:
            # over a few missing samples by the speed, where that makes a difference
            going = self._angle + self._speed * (t[0] - self._t)
            angle = angle + np.pi * np.rint((going - angle[0]) / np.pi)
            self._speed = float((angle[-1] - self._angle) / (t[-1] - self._t))
        self._t, self._angle = float(t[-1]), float(angle[-1])
        return angle

    def _next(self, t: float, principal: float) -> float:
        """The angle of one reading of a single bridge."""
        if self._t is None:
            self._t, self._angle = t, principal
            return principal
        dt, self._t = t - self._t, t
        going = self._angle + dt * (self._speed + 0.5 * dt * self._acceleration)
        slope = math.cos(2.0 * going)
        error = 0.5 * (math.sin(2.0 * principal) - math.sin(2.0 * going))
        error *= slope / (slope * slope + _DEAF)
        # the critically damped filter of third order
        z = math.exp(-dt / _MEMORY)
        self._angle = going + (1.0 - z**3) * error
        self._speed += dt * self._acceleration + 1.5 * (1.0 - z * z) * (1.0 - z) * error / dt
        self._acceleration += (1.0 - z) ** 3 * error / (dt * dt)

        # pieces of the sine between two folds: rising where even, falling where odd
        piece = math.floor(self._angle / _FOLD + 0.5)
        doubtful = slope * slope < _DEAF and abs(self._speed) < SLOW
        if doubtful and not self._doubtful:
            self.uncertain.append(t)
        self._doubtful = doubtful
        return piece * _FOLD + (principal if piece % 2 == 0 else -principal)
