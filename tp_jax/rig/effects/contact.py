"""The contact of rider and column: normal force times a coefficient of friction.

What is called dry friction of the contact is Ts1 + Tst (1 - exp(-T0 |v2|)).
"""

import math

from tp_jax.rig.effects.base import Effect
from tp_jax.rig.effects.maxwell_slip import MaxwellSlip


class ContactEffect(Effect):
    """Base class of the contact's effects."""

    channel, location = "contact", "contact"
    needs_rider = True


class ContactStribeck(ContactEffect):
    """Friction is higher at rest and at low speed: the same at rest as at the onset of sliding."""

    id = "contact_stribeck"
    formula = "dry friction times 1 + a exp(-(v2 / vs)^2)"
    shapes = {"vs": 1.0}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.grip.append(lambda m: a * math.exp(-((m.speed / vs) ** 2)))

    def drawn(self, dice):
        return self._drawn(dice.between(0.3, 0.8), vs=dice.between(0.3, 2.0))


class ContactPosition(ContactEffect):
    """Friction differs round the turn of the rider."""

    id = "contact_position"
    formula = "dry friction times 1 + R cos(n phi2 - beta), a = R cos beta, b = R sin beta"
    unit = ("1", "1")
    amplitudes = ("a", "b")
    shapes = {"n": 3.0}  # noqa: RUF012

    def install(self, run, a, b):
        n, R, beta = run.shapes["n"], math.hypot(a, b), math.atan2(b, a)
        run.hooks.grip.append(lambda m: R * math.cos(n * m.phi2 - beta))

    def drawn(self, dice):
        return self._drawn(*dice.direction(0.2, 0.5), n=dice.whole(1, 6))


class ContactPresliding(ContactEffect):
    """A part of the friction sits on bristles that bend before they slip."""

    id = "contact_presliding"
    formula = "dry friction times 1 - a as Coulomb's, times a N(phi2), a Maxwell-slip network"
    shapes = {"z0": 0.02}  # noqa: RUF012

    def install(self, run, a):
        p = run.parameters
        net = MaxwellSlip(run.shapes["z0"])

        def torque(m):
            dry = p.Ts1 - p.Tst * math.expm1(-p.T0 * abs(m.v2))
            return a * dry * net.torque(m.phi2)

        run.hooks.commits.append(lambda m, _: net.begin(m.phi2))
        run.hooks.grip.append(lambda _: -a)
        run.hooks.contact.append(torque)
        run.hooks.events.append(lambda m: net.to_kink(m.phi2))

    def drawn(self, dice):
        return self._drawn(dice.between(0.6, 1.0), z0=dice.between(0.01, 0.05))


class ContactWear(ContactEffect):
    """The surfaces change as the run goes on."""

    id = "contact_wear"
    formula = "dry friction times 1 + a s"

    def install(self, run, a):
        run.hooks.grip.append(lambda m: a * m.s)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.15, 0.6))


class ContactAsymmetry(ContactEffect):
    """Friction of one sense of sliding is not that of the other."""

    id = "contact_asymmetry"
    formula = "dry friction times 1 + a forward, 1 - a backward"

    def install(self, run, a):
        run.hooks.grip.append(lambda m: a * m.side)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.1, 0.4))


class ContactVibration(ContactEffect):
    """The column shakes up and down and with it the normal force, at a phase new in every run.

    Where the rider would be thrown off, the normal force is zero.
    """

    id = "contact_vibration"
    formula = "normal force times 1 + a_r cos W t + b_r sin W t, hypot(a_r, b_r) the size"
    unit = ("1", "1")
    amplitudes = ("a", "b")
    shapes = {"W": 12.0}  # noqa: RUF012
    per_run = True

    def install(self, run, a, b):
        W, R, lag = 2.0 * math.pi * run.shapes["W"], math.hypot(a, b), math.atan2(b, a)
        run.hooks.grip.append(lambda m: R * math.cos(W * m.t - lag))
        # a stuck rider must not miss the moment of least force
        run.hooks.longest = min(run.hooks.longest, 0.6 / W)

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.6), 0.0, W=dice.between(4.0, 30.0))

    def draw_run(self, rng, sizes):
        size, phase = math.hypot(*sizes), rng.uniform(0.0, 2.0 * math.pi)
        return float(size * math.cos(phase)), float(size * math.sin(phase))


class ContactCogging(ContactEffect):
    """The magnets of the rider's sensor pull it, sliding or not, towards angles they prefer."""

    id = "contact_cogging"
    formula = "M_T + R sin(n phi2 + beta), a = R cos beta, b = R sin beta"
    unit = ("N m", "N m")
    amplitudes = ("a", "b")
    shapes = {"n": 2.0}  # noqa: RUF012

    def install(self, run, a, b):
        n, R, beta = run.shapes["n"], math.hypot(a, b), math.atan2(b, a)
        run.hooks.contact.append(lambda m: R * math.sin(n * m.phi2 + beta))

    def drawn(self, dice):
        a, b = dice.direction(0.1, 0.4)
        return self._drawn(a * dice.rig.Ts1, b * dice.rig.Ts1, n=dice.whole(1, 4))


class ContactRepeatability(ContactEffect):
    """The rider is put on anew for every run, and no two runs have the same friction."""

    id = "contact_repeatability"
    formula = "Ts1 (1 + a_r), the size is the standard deviation of a_r"
    per_run = True
    relative = True

    def install(self, run, a):
        run.hooks.grip_base += a

    def drawn(self, dice):
        return self._drawn(dice.between(0.08, 0.25))

    def draw_run(self, rng, sizes):
        return (float(max(rng.standard_normal() * sizes[0], -0.9)),)
