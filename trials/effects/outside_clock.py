"""Effects of clocks beyond the package's catalogue."""

from trials.effects.base import Outside


class ClockJitter(Outside):
    """Samples are taken late, each by another time, and stamped as if they were not."""

    id = "clock_jitter"
    formula = "true t = recorded t + a |xi|, xi normal"
    unit = ("s",)
    channel = location = "clock"

    def install(self, run, a):
        rng = run.rng
        run.hooks.stamps.append(lambda t: t + abs(a * float(rng.standard_normal())))

    def drawn(self, dice):
        return self._drawn(dice.between(0.001, 0.003))


class ClockJumps(Outside):
    """The recorder loses some samples, three times a run, and counts on as if there were none."""

    id = "clock_jumps"
    formula = "true t = recorded t + a times the number of gaps so far"
    unit = ("s",)
    channel = location = "clock"

    def install(self, run, a):
        gaps = sorted((run.duration * run.rng.uniform(0.1, 0.9, 3)).tolist())
        run.hooks.stamps.append(lambda t: t + abs(a) * sum(t >= gap for gap in gaps))

    def drawn(self, dice):
        return self._drawn(dice.between(0.01, 0.04))
