"""Other formulas of what the catalogue knows of the contact; all but one act on its dry friction.

Dry friction of the contact is Ts1 + Tst (1 - exp(-T0 |v2|)).
"""

import math

from trials.effects.base import Cousin
from trials.effects.patterns import NEXT, Side, bump, saw, settling


class _OfContact(Cousin):
    channel, location = "contact", "contact"
    needs_rider = True


class ContactStribeckExponential(_OfContact):
    """Friction falls from rest on as an exponential, with a kink where the Gaussian is flat."""

    id = "contact_stribeck_exponential"
    formula = "dry friction times 1 + a exp(-|v2| / vs)"
    cousin_of, family = "contact_stribeck", "contact_dry.v2"
    shapes = {"vs": 1.0}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.grip.append(lambda m: a * math.exp(-m.speed / vs))

    def drawn(self, dice):
        return self._drawn(dice.between(0.3, 0.8), vs=dice.between(0.3, 2.0))


class ContactSquare(_OfContact):
    """Sectors of the contact rub more and less by turns."""

    id = "contact_square"
    formula = "dry friction times 1 + a sign cos(n phi2 - beta)"
    cousin_of, family = "contact_position", "contact_dry.phi2"
    shapes = {"n": 3.0, "beta": 1.0}  # noqa: RUF012

    def install(self, run, a):
        n, beta = run.shapes["n"], run.shapes["beta"]
        side = Side(run.hooks, lambda m, later: math.cos(n * (m.phi2 + later * m.v2) - beta))
        run.hooks.grip.append(lambda _: a * side.sign)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.2, 0.5), n=dice.whole(2, 6), beta=dice.between(0.1, 3.0))


class ContactBump(_OfContact):
    """A scratch: more friction in one place."""

    id = "contact_bump"
    formula = "dry friction times 1 + a exp(-((phi2 - centre) / width)^2 / 2)"
    cousin_of, family = "contact_position", "contact_dry.phi2"
    shapes = {"centre": 0.1, "width": 0.1}  # noqa: RUF012

    def install(self, run, a):
        centre, width = run.shapes["centre"], run.shapes["width"]
        run.hooks.grip.append(lambda m: a * bump(m.phi2, centre, width))

    def drawn(self, dice):
        size = dice.between(0.4, 1.2)
        return self._drawn(size, centre=dice.between(0.02, 0.3), width=dice.between(0.05, 0.2))


class ContactWearExponential(_OfContact):
    """Surfaces that are run in after a part of the run."""

    id = "contact_wear_exponential"
    formula = "dry friction times 1 + a e(s), e from -1/2 to 1/2 with time constant tau"
    cousin_of, family = "contact_wear", "contact_dry.t"
    shapes = {"tau": 0.25}  # noqa: RUF012

    def install(self, run, a):
        tau = run.shapes["tau"]
        run.hooks.grip.append(lambda m: a * settling(m.s, tau))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.15, 0.6), tau=dice.between(0.1, 0.4))


class ContactAsymmetrySpeed(_OfContact):
    """One sense of sliding rubs more than the other, the faster the more so."""

    id = "contact_asymmetry_speed"
    formula = "dry friction times 1 + a sign v2 |v2| / (|v2| + vs)"
    cousin_of, family = "contact_asymmetry", "contact_dry.v2"
    shapes = {"vs": 1.0}  # noqa: RUF012

    def install(self, run, a):
        vs = run.shapes["vs"]
        run.hooks.grip.append(lambda m: a * m.side * m.speed / (m.speed + vs))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.15, 0.5), vs=dice.between(0.3, 2.0))


class ContactCoggingSaw(_OfContact):
    """Magnets that let go at an edge: a torque that rises with the angle and falls back at once."""

    id = "contact_cogging_saw"
    formula = "M_T + a saw(n phi2 - beta), from -1 to 1 in every period, also when stuck"
    unit = ("N m",)
    cousin_of, family = "contact_cogging", "contact.phi2"
    shapes = {"n": 2.0, "beta": 1.0}  # noqa: RUF012

    def install(self, run, a):
        n, beta = run.shapes["n"], run.shapes["beta"]

        def argument(m, later=0.0):
            return n * (m.phi2 + later * m.v2) - beta

        # the period that a step is in; it ends where the saw jumps
        period = 0.0

        def commit(m, _):
            nonlocal period
            x = argument(m, NEXT)
            period = round((x - math.pi * saw(x)) / (2.0 * math.pi))

        run.hooks.commits.append(commit)
        run.hooks.events.append(lambda m: math.cos(0.5 * argument(m)))
        run.hooks.contact.append(lambda m: a * (argument(m) / math.pi - 2.0 * period))

    def drawn(self, dice):
        size = dice.signed(0.1, 0.4) * dice.rig.Ts1
        return self._drawn(size, n=dice.whole(1, 4), beta=dice.between(0.1, 3.0))


class _Vibration(_OfContact):
    cousin_of, family = "contact_vibration", "contact_dry.t"
    per_run = True
    amplitudes = ("a", "b")
    unit = ("1", "1")

    def draw_run(self, rng, sizes):
        size, phase = math.hypot(*sizes), rng.uniform(0.0, 2.0 * math.pi)
        return float(size * math.cos(phase)), float(size * math.sin(phase))

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.6), 0.0, W=dice.between(4.0, 20.0))


class ContactVibrationSquare(_Vibration):
    """The normal force is switched by turns, as by a relay."""

    id = "contact_vibration_square"
    formula = "dry friction times 1 + R sign cos(W t - lag), R and lag of a_r and b_r"
    shapes = {"W": 12.0}  # noqa: RUF012

    def install(self, run, a, b):
        W, R, lag = 2.0 * math.pi * run.shapes["W"], math.hypot(a, b), math.atan2(b, a)
        side = Side(run.hooks, lambda m, later: math.cos(W * (m.t + later) - lag))
        run.hooks.grip.append(lambda _: R * side.sign)
        run.hooks.longest = min(run.hooks.longest, 0.6 / W)


class ContactVibrationChirp(_Vibration):
    """The normal force vibrates at a frequency that rises as the run goes on."""

    id = "contact_vibration_chirp"
    formula = "dry friction times 1 + R cos(W (1 + rise s / 2) t' - lag), t' from mid-run"
    shapes = {"W": 12.0, "rise": 0.2}  # noqa: RUF012

    def install(self, run, a, b):
        W, R, lag = 2.0 * math.pi * run.shapes["W"], math.hypot(a, b), math.atan2(b, a)
        rise, lasts = run.shapes["rise"], run.duration
        run.hooks.grip.append(
            lambda m: R * math.cos(W * (1.0 + 0.5 * rise * m.s) * m.s * lasts - lag)
        )
        run.hooks.longest = min(run.hooks.longest, 0.6 / W)

    def drawn(self, dice):
        size, W = dice.between(0.2, 0.6), dice.between(4.0, 20.0)
        return self._drawn(size, 0.0, W=W, rise=dice.between(0.05, 0.4))
