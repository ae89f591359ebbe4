"""Other formulas of what the catalogue knows of the spring."""

import math

from trials.effects.base import Cousin
from trials.effects.patterns import settling


class _OfSpring(Cousin):
    channel, location = "column", "spring"


class SpringHardeningQuintic(_OfSpring):
    """A spring that is straight for long and then hardens at once."""

    id = "spring_hardening_quintic"
    formula = "k (d + a d^5)"
    unit = ("1/rad^4",)
    cousin_of, family = "spring_hardening", "spring.d"

    def install(self, run, a):
        gain = run.parameters.k * a
        run.hooks.column.append(lambda m: gain * m.d**5)

    def drawn(self, dice):
        return self._drawn(dice.one_of(dice.between(0.2, 0.8), -dice.between(0.03, 0.08)))


class SpringHardeningExponential(_OfSpring):
    """Coils that close one after the other."""

    id = "spring_hardening_exponential"
    formula = "k (d + a w sign d (exp(|d| / w) - 1 - |d| / w))"
    cousin_of, family = "spring_hardening", "spring.d"
    shapes = {"w": 0.5}  # noqa: RUF012

    def install(self, run, a):
        w = run.shapes["w"]
        gain = run.parameters.k * a * w

        def torque(m):
            x = abs(m.d) / w
            # far out the law is none of a spring's; a step that is tried may look there
            return math.copysign(gain * (math.expm1(min(x, 20.0)) - x), m.d)

        run.hooks.column.append(torque)

    def drawn(self, dice):
        return self._drawn(dice.between(0.05, 0.2), w=dice.between(0.4, 0.8))


class SpringAsymmetrySmooth(_OfSpring):
    """One stiffness passes into the other over some degrees."""

    id = "spring_asymmetry_smooth"
    formula = "k (d + a (sqrt(d^2 + w^2) - w))"
    cousin_of, family = "spring_asymmetry", "spring.d"
    shapes = {"w": 0.1}  # noqa: RUF012

    def install(self, run, a):
        w, gain = run.shapes["w"], run.parameters.k * a
        run.hooks.column.append(lambda m: gain * (math.hypot(m.d, w) - w))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.04, 0.15), w=dice.between(0.05, 0.3))


class SpringAsymmetryQuadratic(_OfSpring):
    """Stiffness that rises to one side and falls to the other."""

    id = "spring_asymmetry_quadratic"
    formula = "k (d + a d^2)"
    unit = ("1/rad",)
    cousin_of, family = "spring_asymmetry", "spring.d"

    def install(self, run, a):
        gain = run.parameters.k * a
        run.hooks.column.append(lambda m: gain * m.d * m.d)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.05, 0.2))


class SpringRelaxationExponential(_OfSpring):
    """The spring settles in a part of the run."""

    id = "spring_relaxation_exponential"
    formula = "k (1 + a e(s)) d, e from -1/2 to 1/2 with time constant tau"
    cousin_of, family = "spring_relaxation", ""
    shapes = {"tau": 0.25}  # noqa: RUF012

    def install(self, run, a):
        tau, gain = run.shapes["tau"], run.parameters.k * a
        run.hooks.column.append(lambda m: gain * settling(m.s, tau) * m.d)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.03, 0.12), tau=dice.between(0.1, 0.4))
