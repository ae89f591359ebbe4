"""Another formula of what the catalogue knows of the column."""

import math

from trials.effects.base import Cousin


class ColumnTiltSecond(Cousin):
    """Gravity on an arm that bends: a second harmonic in addition to the first."""

    id = "column_tilt_second"
    formula = "-a (sin(phi1 + beta) + r sin 2 (phi1 + beta))"
    unit = ("N m",)
    channel, location = "column", "column"
    cousin_of, family = "column_tilt", "column.phi1"
    shapes = {"beta": 1.0, "r": 0.5}  # noqa: RUF012

    def install(self, run, a):
        beta, r = run.shapes["beta"], run.shapes["r"]

        def torque(m):
            x = m.phi1 + beta
            return -a * (math.sin(x) + r * math.sin(2.0 * x))

        run.hooks.column.append(torque)

    def drawn(self, dice):
        size = dice.signed(0.1, 0.3) * dice.rig.k * dice.rig.A
        return self._drawn(size, beta=dice.between(0.1, 3.0), r=dice.between(0.3, 1.0))
