"""The motor and its arm."""

import math

from tp_jax.rig.effects.base import Effect
from tp_jax.rig.effects.play import Play

SOON = 1e-9  # s: a break nearer than this is behind
OPEN = 1e-10  # rad: a gap with less left is closed
DIFFERENCE = 1e-6  # s: half the interval of a slope


class DriveHarmonics(Effect):
    """Cam and arm: a second crank of twice the speed, and an arm that bends the angle.

    The crank's u = A sin theta, the arm makes of it u - (2 b / A) u^2.
    """

    id = "drive_harmonics"
    formula = "f = A (sin theta + a sin 2 theta) - 2 b A sin^2 theta"
    unit = ("1", "1")
    channel, location = "column", "drive"
    amplitudes = ("a", "b")

    def install(self, run, a, b):
        A = run.parameters.A
        run.hooks.drive.append(
            lambda f, theta: f + a * A * math.sin(2.0 * theta) - 2.0 * b * A * math.sin(theta) ** 2
        )

    def drawn(self, dice):
        return self._drawn(*dice.direction(0.04, 0.12))


class DriveFrequency(Effect):
    """The motor turns faster or slower than commanded, in each run by another amount."""

    id = "drive_frequency"
    formula = "theta = (omega + a_r) t, |a_r| up to the size"
    unit = ("rad/s",)
    channel, location = "column", "drive"
    per_run = True

    def install(self, run, a):
        run.hooks.detuning += a

    def drawn(self, dice):
        return self._drawn(dice.between(0.1, 0.4))

    def draw_run(self, rng, sizes):
        return (float(rng.uniform(-1.0, 1.0)) * sizes[0],)


class DriveSteps(Effect):
    """The motor steps: its angle is a staircase, and a step of the integration ends at each tread.

    With a = 1 the motor stands still between steps. Even whole steps show less than noise in a
    reading; finer ones, 1e5 a run, take their time.
    """

    id = "drive_steps"
    formula = "theta + a (q round(theta / q) - theta)"
    channel, location = "column", "drive"
    shapes = {"q": math.pi / 100}  # noqa: RUF012

    def install(self, run, a):
        q = run.shapes["q"]
        if run.omega is None:
            return
        tread = 0

        def limit(t, h):
            nonlocal tread
            rate = (run.omega + run.hooks.detuning) / q
            tread = math.floor(rate * t + 0.5)
            ahead = (tread + 0.5) / rate - t
            if ahead < SOON:
                tread += 1
                ahead += 1.0 / rate
            return min(h, ahead)

        run.hooks.limits.append(limit)
        run.hooks.phase.append(lambda theta, _: theta + a * (q * tread - theta))

    def drawn(self, dice):  # noqa: ARG002
        return self._drawn(1.0, q=math.pi / 100)


class DriveBacklash(Effect):
    """A gap between the motor and the spring: the play operator on the arm's angle."""

    id = "drive_backlash"
    formula = "f_e = play of f with half width g"
    unit = ("rad",)
    channel, location = "column", "drive"
    amplitudes = ("g",)
    stage = 1

    def install(self, run, g):
        if run.omega is None:
            return
        play = Play(abs(g))
        seen = 0.0

        def follow(f, _):
            nonlocal seen
            seen = f
            return play.follow(f)

        def before(t):
            angle(t)
            return seen

        def slope(t):
            return before(t + DIFFERENCE) - before(t - DIFFERENCE)

        def limit(t, h):
            # no turning point of the arm within a step, and no end of the gap
            play.begin(before(t))
            if slope(t + SOON) * slope(t + h) < 0.0:
                h = _first(lambda x: slope(t + x) * slope(t + SOON) < 0.0, h)
            if play.half - abs(before(t) - play.rest) > OPEN:
                over = lambda x: abs(before(t + x) - play.rest) > play.half  # noqa: E731
                if over(h):
                    h = _first(over, h)
            return max(h, SOON)

        def late(finished):
            nonlocal angle
            angle = finished

        angle = lambda _: 0.0  # noqa: E731
        run.hooks.drive.append(follow)
        run.hooks.limits.append(limit)
        run.hooks.late.append(late)

    def drawn(self, dice):
        return self._drawn(dice.between(0.04, 0.12) * dice.rig.A)


def _first(holds, h: float) -> float:
    """The least x up to `h` from which on `holds`, by bisection."""
    low = 0.0
    for _ in range(45):
        middle = 0.5 * (low + h)
        low, h = (low, middle) if holds(middle) else (middle, h)
    return h
