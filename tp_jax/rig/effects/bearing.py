"""The bearing of the column: Coulomb friction of limit M1 times what stands here, and more."""

import math

from tp_jax.rig.effects.base import Effect
from tp_jax.rig.effects.maxwell_slip import MaxwellSlip


class BearingStribeck(Effect):
    """Friction is higher at rest and at low speed: the same at rest as at the onset of sliding."""

    id = "bearing_stribeck"
    formula = "limit M1 (1 + a exp(-(v1 / vs)^2))"
    channel, location = "column", "bearing"
    shapes = {"vs": 0.3}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.bearing.append(lambda m: a * math.exp(-((m.speed / vs) ** 2)))

    def drawn(self, dice):
        return self._drawn(dice.between(0.4, 1.2), vs=dice.between(0.3, 1.5))


class BearingPosition(Effect):
    """Friction differs round the turn."""

    id = "bearing_position"
    formula = "limit M1 (1 + R cos(n phi1 - beta)), a = R cos beta, b = R sin beta"
    unit = ("1", "1")
    channel, location = "column", "bearing"
    amplitudes = ("a", "b")
    shapes = {"n": 3.0}  # noqa: RUF012

    def install(self, run, a, b):
        n, R, beta = run.shapes["n"], math.hypot(a, b), math.atan2(b, a)
        run.hooks.bearing.append(lambda m: R * math.cos(n * m.phi1 - beta))

    def drawn(self, dice):
        return self._drawn(*dice.direction(0.3, 0.8), n=dice.whole(1, 6))


class BearingPresliding(Effect):
    """A part of the friction sits on bristles that bend before they slip."""

    id = "bearing_presliding"
    formula = "Coulomb of limit M1 (1 - a) and M1 a N(phi1), a Maxwell-slip network of length z0"
    channel, location = "column", "bearing"
    shapes = {"z0": 0.01}  # noqa: RUF012

    def install(self, run, a):
        net: MaxwellSlip | None = None
        most = a * run.parameters.M1

        def commit(m, _):
            nonlocal net
            net = net or MaxwellSlip(run.shapes["z0"], m.phi1)
            net.begin(m.phi1)

        run.hooks.commits.append(commit)
        run.hooks.bearing.append(lambda _: -a)
        run.hooks.column.append(lambda m: 0.0 if net is None else -most * net.torque(m.phi1))
        run.hooks.events.append(lambda m: 1.0 if net is None else net.to_kink(m.phi1))

    def drawn(self, dice):
        return self._drawn(dice.between(0.6, 1.0), z0=dice.between(0.01, 0.03))


class BearingDrag(Effect):
    """Air drag: against the motion, with the square of its speed."""

    id = "bearing_drag"
    formula = "a v1 |v1|"
    unit = ("N m s^2/rad^2",)
    channel, location = "column", "bearing"

    def install(self, run, a):
        run.hooks.column.append(lambda m: -math.copysign(a * m.v1 * m.v1, m.v1))

    def drawn(self, dice):
        # a part of the viscous torque at 5 rad/s
        return self._drawn(dice.between(0.15, 0.6) * dice.rig.c1 / 5.0)


class BearingWarmup(Effect):
    """Grease that warms up: all friction of the bearing changes as the run goes on."""

    id = "bearing_warmup"
    formula = "limit M1 (1 + a s), c1 (1 + a s)"
    channel, location = "column", "bearing"

    def install(self, run, a):
        viscous = a * run.parameters.c1
        run.hooks.bearing.append(lambda m: a * m.s)
        run.hooks.column.append(lambda m: -viscous * m.s * m.v1)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.2, 0.7))


class BearingAsymmetry(Effect):
    """Friction of one sense of rotation is not that of the other."""

    id = "bearing_asymmetry"
    formula = "limit M1 (1 + a) forward, M1 (1 - a) backward"
    channel, location = "column", "bearing"

    def install(self, run, a):
        run.hooks.bearing.append(lambda m: a * m.side)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.3, 0.7))


class BearingLoad(Effect):
    """The spring does not pull at the column's axis alone, and presses it into the bearing."""

    id = "bearing_load"
    formula = "limit M1 + a |k d|"
    channel, location = "column", "bearing"

    def install(self, run, a):
        k = run.parameters.k
        run.hooks.load.append(lambda m: abs(a * k * m.d))
        run.hooks.events.append(lambda m: m.d)

    def drawn(self, dice):
        return self._drawn(dice.between(0.04, 0.15))
