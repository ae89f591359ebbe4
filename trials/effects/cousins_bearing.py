"""Other formulas of what the catalogue knows of the bearing."""

import math

from trials.effects.base import Cousin
from trials.effects.patterns import Side, bump, settling


class _OfBearing(Cousin):
    channel, location = "column", "bearing"


class BearingStribeckExponential(_OfBearing):
    """Friction falls from rest on as an exponential, with a kink where the Gaussian is flat."""

    id = "bearing_stribeck_exponential"
    formula = "limit M1 (1 + a exp(-|v1| / vs))"
    cousin_of, family = "bearing_stribeck", "bearing_dry.v1"
    shapes = {"vs": 0.3}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.bearing.append(lambda m: a * math.exp(-m.speed / vs))

    def drawn(self, dice):
        return self._drawn(dice.between(0.4, 1.2), vs=dice.between(0.3, 1.5))


class BearingDragPower(_OfBearing):
    """Drag between laminar and turbulent."""

    id = "bearing_drag_power"
    formula = "a |v1|^1.6 sign v1"
    unit = ("N m s^1.6/rad^1.6",)
    cousin_of, family = "bearing_drag", "bearing_viscous.v1"

    def install(self, run, a):
        run.hooks.column.append(lambda m: -math.copysign(a * abs(m.v1) ** 1.6, m.v1))

    def drawn(self, dice):
        # a part of the viscous torque at 5 rad/s
        return self._drawn(dice.between(0.2, 0.8) * dice.rig.c1 / 5.0**0.6)


class BearingSquare(_OfBearing):
    """Sectors of the bearing rub more and less by turns."""

    id = "bearing_square"
    formula = "limit M1 (1 + a sign cos(n phi1 - beta))"
    cousin_of, family = "bearing_position", "bearing_dry.phi1"
    shapes = {"n": 3.0, "beta": 1.0}  # noqa: RUF012

    def install(self, run, a):
        n, beta = run.shapes["n"], run.shapes["beta"]
        side = Side(run.hooks, lambda m, later: math.cos(n * (m.phi1 + later * m.v1) - beta))
        run.hooks.bearing.append(lambda _: a * side.sign)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.3, 0.8), n=dice.whole(2, 6), beta=dice.between(0.1, 3.0))


class BearingBump(_OfBearing):
    """Dirt in one place of the bearing."""

    id = "bearing_bump"
    formula = "limit M1 (1 + a exp(-((phi1 - centre) / width)^2 / 2))"
    cousin_of, family = "bearing_position", "bearing_dry.phi1"
    shapes = {"centre": 0.05, "width": 0.06}  # noqa: RUF012

    def install(self, run, a):
        centre, width = run.shapes["centre"], run.shapes["width"]
        run.hooks.bearing.append(lambda m: a * bump(m.phi1, centre, width))

    def drawn(self, dice):
        size, A = dice.between(0.8, 2.0), dice.rig.A
        centre, width = dice.between(0.1, 0.8) * A, dice.between(0.2, 0.5) * A
        return self._drawn(size, centre=centre, width=width)


class BearingWarmupExponential(_OfBearing):
    """Grease that is warm after a part of the run."""

    id = "bearing_warmup_exponential"
    formula = "limit M1 (1 + a e(s)), c1 (1 + a e(s)), e from -1/2 to 1/2 with time constant tau"
    cousin_of, family = "bearing_warmup", "bearing_dry.t"
    shapes = {"tau": 0.25}  # noqa: RUF012

    def install(self, run, a):
        tau, viscous = run.shapes["tau"], a * run.parameters.c1
        run.hooks.bearing.append(lambda m: a * settling(m.s, tau))
        run.hooks.column.append(lambda m: -viscous * settling(m.s, tau) * m.v1)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.2, 0.7), tau=dice.between(0.1, 0.4))


class BearingAsymmetrySpeed(_OfBearing):
    """Winding up rubs more than unwinding, the faster the more so."""

    id = "bearing_asymmetry_speed"
    formula = "limit M1 (1 + a sign v1 |v1| / (|v1| + vs))"
    cousin_of, family = "bearing_asymmetry", "bearing_dry.v1"
    shapes = {"vs": 1.0}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.bearing.append(lambda m: a * m.side * m.speed / (m.speed + vs))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.3, 0.7), vs=dice.between(0.3, 2.0))
