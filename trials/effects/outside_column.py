"""Effects on the column beyond the package's catalogue."""

from trials.effects.base import Outside

SOON = 1e-9  # s: a break nearer than this is behind


def until(t: float, h: float, breaks) -> float:
    """The part of a step before the next of some times, in order [s]."""
    for at in breaks:
        if at > t + SOON:
            return min(h, at - t)
    return h


class SpringClampSlip(Outside):
    """The clamp slips once in every run, and the spring is longer or shorter from then on."""

    id = "spring_clamp_slip"
    formula = "stiffness k before and k (1 + a) after a moment of the run's middle third"
    channel, location = "column", "spring"
    cousin_of, family = "spring_relaxation", ""

    def install(self, run, a):
        at = run.duration * float(run.rng.uniform(1 / 3, 2 / 3))
        gain = 0.0

        def limit(t, h):
            nonlocal gain
            gain = a * run.parameters.k if t + SOON >= at else 0.0
            return until(t, h, (at,))

        run.hooks.limits.append(limit)
        run.hooks.column.append(lambda m: gain * m.d)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.06, 0.15))


class ColumnMagnet(Outside):
    """A magnet near the column: a pull that is strong near one angle and nothing farther away."""

    id = "column_magnet"
    formula = "-a u (2 / (1 + u^2))^2, u = (phi1 - centre) / width"
    unit = ("N m",)
    channel, location = "column", "column"
    shapes = {"centre": 0.12, "width": 0.05}  # noqa: RUF012

    def install(self, run, a):
        centre, width = run.shapes["centre"], run.shapes["width"]

        def torque(m):
            u = (m.phi1 - centre) / width
            return -a * u * (2.0 / (1.0 + u * u)) ** 2

        run.hooks.column.append(torque)

    def drawn(self, dice):
        size = dice.signed(0.08, 0.25) * dice.rig.k * dice.rig.A
        return self._drawn(size, centre=dice.between(0.5, 1.2) * dice.rig.A, width=dice.rig.A / 4.0)


class FluidDamper(Outside):
    """The column drags a fluid along: a damper behind a spring (Maxwell element)."""

    id = "fluid_damper"
    formula = "-T, T' = a v1 - T / tau"
    unit = ("N m/rad",)
    channel, location = "column", "column"
    shapes = {"tau": 0.1}  # noqa: RUF012

    def install(self, run, a):
        tau = run.shapes["tau"]
        own = run.hooks.state(0.0)
        run.hooks.column.append(lambda m: -m.z[own])
        run.hooks.rates.append(lambda m: (a * m.v1 - m.z[own] / tau,))

    def drawn(self, dice):
        size = dice.between(0.1, 0.3) * dice.rig.k
        return self._drawn(size, tau=dice.between(0.05, 0.3))


class MotorStall(Outside):
    """The motor stands still for a moment, some times in every run, and lags for good."""

    id = "motor_stall"
    formula = "theta stands for a / omega, three times a run"
    unit = ("rad",)
    channel, location = "column", "drive"

    def install(self, run, a):
        if run.omega is None:
            return
        lasts = abs(a) / run.omega
        starts = sorted((run.duration * run.rng.uniform(0.1, 0.9, 3)).tolist())
        breaks = sorted([*starts, *(at + lasts for at in starts)])

        def stalled(theta, t):
            lost = sum(min(max(t - at, 0.0), lasts) for at in starts)
            return theta - run.omega * lost

        run.hooks.phase.append(stalled)
        run.hooks.limits.append(lambda t, h: until(t, h, breaks))

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.8))


class BearingRim(Outside):
    """The column rubs on something once it has turned far enough to either side."""

    id = "bearing_rim"
    formula = "limit M1 (1 + a) where |phi1| exceeds the rim"
    channel, location = "column", "bearing"
    cousin_of, family = "bearing_position", "bearing_dry.phi1"
    shapes = {"rim": 0.25}  # noqa: RUF012

    def install(self, run, a):
        rim = run.shapes["rim"]
        outer = False

        def commit(m, _):
            nonlocal outer
            # on the rim itself, the side it goes to decides
            outer = abs(m.phi1 + 1e-9 * m.v1) > rim

        run.hooks.commits.append(commit)
        run.hooks.events.append(lambda m: abs(m.phi1) - rim)
        run.hooks.bearing.append(lambda _: a if outer else 0.0)

    def drawn(self, dice):
        rim = dice.between(0.8, 1.5) * dice.rig.A
        return self._drawn(dice.between(0.8, 2.0), rim=rim)
