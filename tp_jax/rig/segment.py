"""The motion between the ends of a step."""

from collections.abc import Sequence


class Segment:
    """One step that was taken, to be read anywhere in it.

    Angles are quintic Hermite polynomials through angle, velocity and acceleration at both ends,
    in error by h^6 / 46080 times the sixth derivative: below 1e-12 rad for the steps taken. States
    of effects are cubic ones.
    """

    __slots__ = ("angles", "h", "states", "t")

    def __init__(self, t: float, h: float, angles: Sequence, states: Sequence):
        """A step from `t` [s] of length `h`.

        Args:
            angles: for phi1 and phi2: angle, velocity, acceleration at the start, at the end.
            states: for every state: value, rate at the start, at the end.
        """
        self.t, self.h = t, h
        self.angles, self.states = angles, states

    def read(self, t: float) -> tuple[float, float, float, float]:
        """phi1, phi2 [rad], v1, v2 [rad/s] at a time of the step."""
        x = (t - self.t) / self.h if self.h > 0.0 else 1.0
        phi1, v1 = _quintic(x, self.h, *self.angles[0])
        phi2, v2 = _quintic(x, self.h, *self.angles[1])
        return phi1, phi2, v1, v2

    def read_states(self, t: float) -> list[float]:
        """Values of the states at a time of the step."""
        x = (t - self.t) / self.h if self.h > 0.0 else 1.0
        return [_cubic(x, self.h, *state) for state in self.states]


def _quintic(x, h, y0, v0, a0, y1, v1, a1):
    """Value and derivative at y(x h) of the polynomial with these ends."""
    v0, v1, a0, a1 = v0 * h, v1 * h, a0 * h * h, a1 * h * h
    rise = y1 - y0 - v0 - 0.5 * a0
    turn = v1 - v0 - a0
    bend = a1 - a0
    c3 = 10.0 * rise - 4.0 * turn + 0.5 * bend
    c4 = -15.0 * rise + 7.0 * turn - bend
    c5 = 6.0 * rise - 3.0 * turn + 0.5 * bend
    value = y0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
    slope = v0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
    return value, slope / h if h > 0.0 else v1


def _cubic(x, h, y0, v0, y1, v1):
    v0, v1 = v0 * h, v1 * h
    rise = y1 - y0 - v0
    turn = v1 - v0
    return y0 + x * (v0 + x * ((3.0 * rise - turn) + x * (turn - 2.0 * rise)))
