"""Other formulas of what the catalogue knows of the sensors."""

import math

from trials.effects.base import Cousin
from trials.effects.patterns import settling


class _Eccentric(Cousin):
    # The catalogue's formula, written with a phase where that has two sizes: these stay among the
    # cousins so that the rigs that follow from a seed stay the same.
    formula = "y = phi + a (sin(phi + c) - sin c)"
    unit = ("rad",)
    shapes = {"c": 1.0}  # noqa: RUF012

    def drawn(self, dice):
        return self._drawn(dice.signed(0.02, 0.1), c=dice.between(0.1, 3.0))


def eccentric(a, c):
    """Reading of a disc off its axis."""
    return lambda y, _: y + a * (math.sin(y + c) - math.sin(c))


class Sensor1Eccentric(_Eccentric):
    """The column's disc sits off its axis."""

    id = "sensor1_eccentric"
    channel = location = "sensor1"
    cousin_of, family = "sensor1_eccentricity", "sensor1.phi1"

    def install(self, run, a):
        run.hooks.sensor1.append(eccentric(a, run.shapes["c"]))


class Sensor2Eccentric(_Eccentric):
    """The rider's disc sits off its axis."""

    id = "sensor2_eccentric"
    channel = location = "sensor2"
    cousin_of, family = "sensor2_eccentricity", "sensor2.phi2"
    needs_rider = True

    def install(self, run, a):
        run.hooks.sensor2.append(eccentric(a, run.shapes["c"]))


class Sensor1Compression(Cousin):
    """The amplifier of the column's sensor is compressed towards its ends."""

    id = "sensor1_compression"
    formula = "y1 = phi1 - a (phi1 - w tanh(phi1 / w))"
    channel = location = "sensor1"
    cousin_of, family = "sensor1_nonlinearity", "sensor1.phi1"
    shapes = {"w": 0.8}  # noqa: RUF012

    def install(self, run, a):
        w = run.shapes["w"]
        run.hooks.sensor1.append(lambda y, _: y - a * (y - w * math.tanh(y / w)))

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.8), w=dice.between(0.5, 1.0))


class _DriftExponential(Cousin):
    formula = "y = phi (1 + a e(s)) + b e(s), e from -1/2 to 1/2 with time constant tau"
    unit = ("1", "rad")
    amplitudes = ("a", "b")
    shapes = {"tau": 0.25}  # noqa: RUF012

    def drawn(self, dice):
        gain, zero = dice.signed(0.02, 0.1), dice.signed(0.01, 0.04)
        return self._drawn(gain, zero, tau=dice.between(0.1, 0.4))


def drifting(a, b, tau):
    """Reading with a gain and a zero that settle."""

    def read(y, m):
        e = settling(m.s, tau)
        return y * (1.0 + a * e) + b * e

    return read


class Sensor1DriftExponential(_DriftExponential):
    """Drift of the column's sensor, warm after a part of the run."""

    id = "sensor1_drift_exponential"
    channel = location = "sensor1"
    cousin_of, family = "sensor1_drift", ""

    def install(self, run, a, b):
        run.hooks.sensor1.append(drifting(a, b, run.shapes["tau"]))


class Sensor2DriftExponential(_DriftExponential):
    """Drift of the rider's sensor, warm after a part of the run."""

    id = "sensor2_drift_exponential"
    channel = location = "sensor2"
    cousin_of, family = "sensor2_drift", ""
    needs_rider = True

    def install(self, run, a, b):
        run.hooks.sensor2.append(drifting(a, b, run.shapes["tau"]))
