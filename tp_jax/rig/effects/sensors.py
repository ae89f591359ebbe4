"""What the sensors make of the angles; the motion knows nothing of it.

A magnetoresistive bridge gives sin 2 phi, its twin turned by 45 degrees cos 2 phi; both together
give the angle, counted on over the turns.
"""

import math

from tp_jax.rig.effects.base import Effect


class _Nonlinearity(Effect):
    """The firmware trusts the first bridge alone and its straight line, in a share a."""

    formula = "y = (1 - a) phi + a (sin 2 phi) / 2"

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.8))


def straight_line(a):
    """Reading of the angle with a share `a` of the bridge taken as a straight line."""

    def read(y, _):
        bridge = math.sin(2.0 * y)
        return (1.0 - a) * y + a * 0.5 * bridge

    return read


class Sensor1Nonlinearity(_Nonlinearity):
    """Of the column's sensor."""

    id = "sensor1_nonlinearity"
    channel = location = "sensor1"

    def install(self, run, a):
        run.hooks.sensor1.append(straight_line(a))


class Sensor2Nonlinearity(_Nonlinearity):
    """Of the rider's sensor."""

    id = "sensor2_nonlinearity"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a):
        run.hooks.sensor2.append(straight_line(a))


class _Drift(Effect):
    """An amplifier that warms up: gain and zero run away from what they are in mid-run."""

    formula = "y = phi (1 + a s) + b s"
    unit = ("1", "rad")
    amplitudes = ("a", "b")

    def drawn(self, dice):
        return self._drawn(dice.signed(0.02, 0.1), dice.signed(0.01, 0.04))


def drifting(a, b):
    """Reading with a gain and a zero that drift."""

    def read(y, m):
        gain, zero = 1.0 + a * m.s, b * m.s
        return gain * y + zero

    return read


class Sensor1Drift(_Drift):
    """Of the column's sensor."""

    id = "sensor1_drift"
    channel = location = "sensor1"

    def install(self, run, a, b):
        run.hooks.sensor1.append(drifting(a, b))


class Sensor2Drift(_Drift):
    """Of the rider's sensor."""

    id = "sensor2_drift"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a, b):
        run.hooks.sensor2.append(drifting(a, b))


class SensorCrosstalk(Effect):
    """The magnets at the column's foot turn the field at the rider's sensor as well."""

    id = "sensor_crosstalk"
    formula = "y2 = phi2 + a phi1"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a):
        run.hooks.sensor2.append(lambda y, m: y + a * m.phi1)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.01, 0.06))
