"""The column, what it stands on, what hangs on it."""

import math

from tp_jax.rig.effects.base import Effect
from tp_jax.rig.effects.maxwell_slip import MaxwellSlip


class ColumnTilt(Effect):
    """A mass off the axis of a column that does not stand upright: a pendulum in gravity."""

    id = "column_tilt"
    formula = "-m g r sin(phi1 + beta), a = m g r cos beta, b = m g r sin beta"
    unit = ("N m", "N m")
    channel, location = "column", "column"
    amplitudes = ("a", "b")

    def install(self, run, a, b):
        moment, beta = math.hypot(a, b), math.atan2(b, a)
        run.hooks.column.append(lambda m: -moment * math.sin(m.phi1 + beta))

    def drawn(self, dice):
        a, b = dice.direction(0.1, 0.3)
        torque = dice.rig.k * dice.rig.A
        return self._drawn(a * torque, b * torque)


class ColumnCable(Effect):
    """The sensor's cable, bent to and fro: a Maxwell-slip network."""

    id = "column_cable"
    formula = "-a z0 N(phi1), N a Maxwell-slip network of length z0"
    unit = ("N m/rad",)
    channel, location = "column", "column"
    shapes = {"z0": 0.15}  # noqa: RUF012

    def install(self, run, a):
        z0 = run.shapes["z0"]
        net: MaxwellSlip | None = None

        def commit(m, _):
            nonlocal net
            net = net or MaxwellSlip(z0, m.phi1)
            net.begin(m.phi1)

        run.hooks.commits.append(commit)
        run.hooks.column.append(lambda m: 0.0 if net is None else -a * z0 * net.torque(m.phi1))
        run.hooks.events.append(lambda m: 1.0 if net is None else net.to_kink(m.phi1))

    def drawn(self, dice):
        z0 = dice.one_of(0.05, 0.15, 0.5)
        return self._drawn(dice.between(0.08, 0.25) * dice.rig.k, z0=z0)


class BaseCompliance(Effect):
    """The housing is a third body on a spring and a damper of its own, pushed by the reaction.

    Its inertia is B1 / a, its frequency without the column W, its damping ratio zeta.
    """

    id = "base_compliance"
    formula = "(B1 / a) (psi'' + 2 zeta W psi' + W^2 psi) = -(T_spring - M_L)"
    channel, location = "column", "base"
    shapes = {"W": 12.0, "zeta": 0.05}  # noqa: RUF012

    def install(self, run, a):
        W, zeta = 2.0 * math.pi * run.shapes["W"], run.shapes["zeta"]
        inertia = run.parameters.B1 / a
        stiffness, damping = inertia * W * W, 2.0 * inertia * zeta * W
        psi = run.hooks.state(0.0)
        speed = run.hooks.state(0.0)

        def held(m):
            return (stiffness * m.z[psi] + damping * m.z[speed]) / inertia

        run.hooks.recoil, run.hooks.ground = a, held
        run.hooks.rates.append(lambda m: (m.z[speed], -m.pull / inertia - held(m)))
        run.hooks.longest = min(run.hooks.longest, 0.6 / W)

    def drawn(self, dice):
        return self._drawn(
            dice.between(0.05, 0.3),
            W=dice.between(5.0, 20.0),
            zeta=dice.one_of(0.02, 0.1),
        )


class ElasticStop(Effect):
    """A spring on either side that the column meets at an angle s, and leaves there."""

    id = "elastic_stop"
    formula = "-a (phi1 - s) for phi1 > s, b (-s - phi1) for phi1 < -s"
    unit = ("N m/rad", "N m/rad")
    channel, location = "column", "column"
    amplitudes = ("a", "b")
    shapes = {"s": 0.2}  # noqa: RUF012

    def install(self, run, a, b):
        s = run.shapes["s"]

        def push(m):
            if m.phi1 > s:
                return -a * (m.phi1 - s)
            return b * (-s - m.phi1) if m.phi1 < -s else 0.0

        run.hooks.column.append(push)
        run.hooks.events += [lambda m: m.phi1 - s, lambda m: m.phi1 + s]

    def drawn(self, dice):
        a, b = dice.between(0.3, 1.5), dice.between(0.3, 1.5)
        return self._drawn(a * dice.rig.k, b * dice.rig.k, s=dice.between(0.8, 1.6) * dice.rig.A)


class ReactionFactor(Effect):
    """Not all of the contact's torque comes back on the column, or more than all."""

    id = "reaction_factor"
    formula = "B1 v1' = ... + (1 + a) M_T"
    channel, location = "column", "model"
    needs_rider = True

    def install(self, run, a):
        run.hooks.reaction = 1.0 + a

    def drawn(self, dice):
        return self._drawn(dice.signed(0.15, 0.5))
