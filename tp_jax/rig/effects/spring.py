"""The spring between the motor and the column."""

from tp_jax.rig.effects.base import Effect
from tp_jax.rig.effects.maxwell_slip import MaxwellSlip

DIFFERENCE = 1e-6  # s: the interval of a slope
STANDS = 1e-9  # rad/s: a spring that is wound no faster is not wound


class SpringAsymmetry(Effect):
    """Two springs in one: k (1 + a) wound, k (1 - a) unwound."""

    id = "spring_asymmetry"
    formula = "k (1 + a) d for d > 0, k (1 - a) d for d < 0"
    channel, location = "column", "spring"

    def install(self, run, a):
        wound, unwound = a * run.parameters.k, -a * run.parameters.k
        run.hooks.column.append(lambda m: (wound if m.d > 0.0 else unwound) * m.d)
        run.hooks.events.append(lambda m: m.d)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.03, 0.12))


class SpringHysteresis(Effect):
    """Coils that rub: a Maxwell-slip network beside the spring."""

    id = "spring_hysteresis"
    formula = "k (d + a z0 N(d)), N a Maxwell-slip network of length z0"
    channel, location = "column", "spring"
    shapes = {"z0": 0.1}  # noqa: RUF012

    def install(self, run, a):
        z0 = run.shapes["z0"]
        net: MaxwellSlip | None = None
        most = a * run.parameters.k * z0

        def commit(m, _):
            nonlocal net
            # no tension where the run begins
            net = net or MaxwellSlip(z0, m.d)
            net.begin(m.d)

        def turning(m):
            # forward, since an arm with play knows nothing of what was before the step
            arm = (angle(m.t + DIFFERENCE) - angle(m.t)) / DIFFERENCE
            # where arm and column stand still, rounding is no turning
            return arm - m.v1 if abs(arm - m.v1) > STANDS else 0.0

        def late(finished):
            nonlocal angle
            angle = finished

        angle = lambda _: 0.0  # noqa: E731
        run.hooks.commits.append(commit)
        run.hooks.column.append(lambda m: 0.0 if net is None else most * net.torque(m.d))
        run.hooks.events += [turning, lambda m: 1.0 if net is None else net.to_kink(m.d)]
        run.hooks.late.append(late)

    def drawn(self, dice):
        # stiffness of the network at most that of the spring
        return self._drawn(dice.between(0.1, 0.3), z0=dice.one_of(0.03, 0.1, 0.3))


class SpringHardening(Effect):
    """A spring whose energy has a fourth power: stiffer or softer far out."""

    id = "spring_hardening"
    formula = "energy k (d^2 / 2 + a d^4 / 4)"
    unit = ("1/rad^2",)
    channel, location = "column", "spring"

    def install(self, run, a):
        cubic = run.parameters.k * a
        run.hooks.column.append(lambda m: cubic * m.d * m.d * m.d)

    def drawn(self, dice):
        # a spring that softens much more would give way altogether at resonance
        return self._drawn(dice.one_of(dice.between(0.1, 0.4), -dice.between(0.05, 0.15)))


class SpringRelaxation(Effect):
    """The spring loses or gains stiffness as the run goes on."""

    id = "spring_relaxation"
    formula = "k (1 + a s) d"
    channel, location = "column", "spring"

    def install(self, run, a):
        gain = run.parameters.k * a
        run.hooks.column.append(lambda m: gain * m.s * m.d)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.03, 0.12))


class SpringDeadzone(Effect):
    """The hook at the spring's end is wider than the spring: it is taut from a winding g on."""

    id = "spring_deadzone"
    formula = "k (d - g) for d > g, k (d + g) for d < -g, no torque between"
    unit = ("rad",)
    channel, location = "column", "drive"
    amplitudes = ("g",)

    def install(self, run, g):
        k, g = run.parameters.k, abs(g)

        def slack(m):
            if m.d > g:
                return -k * g
            return k * g if m.d < -g else -k * m.d

        run.hooks.column.append(slack)
        run.hooks.events += [lambda m: m.d - g, lambda m: m.d + g]

    def drawn(self, dice):
        return self._drawn(dice.between(0.05, 0.15) * dice.rig.A)
