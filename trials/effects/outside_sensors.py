"""Effects of sensors beyond the package's catalogue."""

from tp_jax.rig.effects.play import Play
from trials.effects.base import Outside

TICK = 0.01  # s: of the random walk


class Sensor1Play(Outside):
    """The magnet of the column's sensor is loose in its holder."""

    id = "sensor1_play"
    formula = "y1 = play of phi1 with half width a"
    unit = ("rad",)
    channel = location = "sensor1"

    def install(self, run, a):
        play: Play | None = None

        def commit(m, _):
            nonlocal play
            play = play or Play(abs(a), m.phi1)
            play.begin(m.phi1)

        run.hooks.commits.append(commit)
        run.hooks.sensor1.append(lambda y, _: y if play is None else play.follow(y))

    def drawn(self, dice):
        return self._drawn(dice.between(0.008, 0.03))


class Sensor1Wander(Outside):
    """The zero of the column's sensor walks at random."""

    id = "sensor1_wander"
    formula = "y1 = phi1 + a W(t), W a Wiener process"
    unit = ("rad/sqrt(s)",)
    channel = location = "sensor1"

    def install(self, run, a):
        rng, path = run.rng, [0.0]

        def read(y, m):
            n, part = divmod(m.t / TICK, 1.0)
            while len(path) < n + 2:
                path.append(path[-1] + a * TICK**0.5 * float(rng.standard_normal()))
            left, right = path[int(n)], path[int(n) + 1]
            return y + left + part * (right - left)

        run.hooks.sensor1.append(read)

    def drawn(self, dice):
        return self._drawn(dice.between(0.005, 0.02))


class Sensor2Lag(Outside):
    """A filter before the converter is too slow."""

    id = "sensor2_lag"
    formula = "a y2' = phi2 - y2"
    unit = ("s",)
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a):
        own = run.hooks.state(0.0)
        run.hooks.rates.append(lambda m: ((m.phi2 - m.z[own]) / abs(a),))
        run.hooks.sensor2.append(lambda _, m: m.z[own])
        run.hooks.longest = min(run.hooks.longest, 0.5 * abs(a))

    def drawn(self, dice):
        return self._drawn(dice.between(0.02, 0.05))


class Sensor2Saturation(Outside):
    """The amplifier of the rider's sensor gives less and less the further it is driven."""

    id = "sensor2_saturation"
    formula = "y2 = phi2 - a phi2 |phi2|"
    unit = ("1/rad",)
    channel = location = "sensor2"
    cousin_of, family = "sensor2_nonlinearity", "sensor2.phi2"
    needs_rider = True

    def install(self, run, a):
        run.hooks.sensor2.append(lambda y, _: y - a * y * abs(y))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.05, 0.2))


class Sensor2Freeze(Outside):
    """A loose contact: the reading of the rider's sensor stands still for moments."""

    id = "sensor2_freeze"
    formula = "y2 holds its value for a seconds, about once a second"
    unit = ("s",)
    channel = location = "sensor2"
    needs_rider = True

    def install(self, run, a):
        lasts = abs(a)
        n = max(int(run.duration), 1)
        starts = [(i + float(x)) * run.duration / n for i, x in enumerate(run.rng.random(n))]
        held: dict[int, float] = {}

        def read(y, m):
            for i, at in enumerate(starts):
                if at <= m.t < at + lasts:
                    return held.setdefault(i, y)
            return y

        run.hooks.sensor2.append(read)

    def drawn(self, dice):
        return self._drawn(dice.between(0.04, 0.12))
