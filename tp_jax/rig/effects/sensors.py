"""Readings that the sensors make of the angles; the motion knows nothing of them.

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
    """Nonlinearity of the column's sensor."""

    id = "sensor1_nonlinearity"
    channel = location = "sensor1"

    def install(self, run, a):
        run.hooks.sensor1.append(straight_line(a))


class Sensor2Nonlinearity(_Nonlinearity):
    """Nonlinearity of the rider's sensor."""

    id = "sensor2_nonlinearity"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a):
        run.hooks.sensor2.append(straight_line(a))


class _Wave(Effect):
    """An error that repeats n times a turn, and is none at zero: R sin of a shifted angle."""

    unit = ("rad", "rad")
    amplitudes = ("a", "b")


def waving(a, b, n):
    """Reading that is off by a wave of n periods a turn."""
    R, beta = math.hypot(a, b), math.atan2(b, a)
    least = R * math.sin(beta)
    return lambda y, _: y + R * math.sin(n * y + beta) - least


class _Eccentricity(_Wave):
    """A disc that is read by one head turns about a point beside its middle."""

    formula = "y = phi + R sin(phi + beta) - R sin beta, a = R cos beta, b = R sin beta"

    def drawn(self, dice):
        return self._drawn(*dice.direction(0.02, 0.1))


class Sensor1Eccentricity(_Eccentricity):
    """Eccentricity of the column's sensor."""

    id = "sensor1_eccentricity"
    channel = location = "sensor1"

    def install(self, run, a, b):
        run.hooks.sensor1.append(waving(a, b, 1.0))


class Sensor2Eccentricity(_Eccentricity):
    """Eccentricity of the rider's sensor."""

    id = "sensor2_eccentricity"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a, b):
        run.hooks.sensor2.append(waving(a, b, 1.0))


class _Interpolation(_Wave):
    """Bridges with an offset (n = 2), or one stronger than its twin (n = 4)."""

    formula = "y = phi + R sin(n phi + beta) - R sin beta, a = R cos beta, b = R sin beta"
    shapes = {"n": 2.0}  # noqa: RUF012

    def drawn(self, dice):
        return self._drawn(*dice.direction(0.01, 0.04), n=dice.one_of(2.0, 4.0))


class Sensor1Interpolation(_Interpolation):
    """Interpolation error of the column's sensor."""

    id = "sensor1_interpolation"
    channel = location = "sensor1"

    def install(self, run, a, b):
        run.hooks.sensor1.append(waving(a, b, run.shapes["n"]))


class Sensor2Interpolation(_Interpolation):
    """Interpolation error of the rider's sensor."""

    id = "sensor2_interpolation"
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a, b):
        run.hooks.sensor2.append(waving(a, b, run.shapes["n"]))


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
    """Drift of the column's sensor."""

    id = "sensor1_drift"
    channel = location = "sensor1"

    def install(self, run, a, b):
        run.hooks.sensor1.append(drifting(a, b))


class Sensor2Drift(_Drift):
    """Drift of the rider's sensor."""

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
