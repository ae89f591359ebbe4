"""Another formula of what the catalogue knows of the drive."""

import math

from trials.effects.base import Cousin


class DriveHarmonicsThird(Cousin):
    """A cam of three lobes."""

    id = "drive_harmonics_third"
    formula = "f = A (sin theta + a sin 3 theta)"
    channel, location = "column", "drive"
    cousin_of, family = "drive_harmonics", "drive.theta"

    def install(self, run, a):
        size = a * run.parameters.A
        run.hooks.drive.append(lambda f, theta: f + size * math.sin(3.0 * theta))

    def drawn(self, dice):
        return self._drawn(dice.signed(0.04, 0.12))
