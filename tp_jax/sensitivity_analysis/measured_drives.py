"""Experiments whose drive is measured, such that its gain is varied about the mean reading.

A motor angle is gain x reading + level. Where the reading has a mean (a sensor of 2.5 V in the
middle), a change of the gain alone would turn the whole column as well, which no fit would see: the
level takes it up. Every derivative by the gain, and every variance, would depend on where the
sensor's zero happens to be. So the reading is taken about its mean, and the level there.
"""

from collections.abc import Mapping

import equinox as eqx
import numpy as np
from numpy.typing import ArrayLike

from tp_jax.identifiability.design import Design
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.model.pendulum import AbstractTorsionPendulum


def about_the_mean(design: Design, gain: float) -> Design:
    """The same experiment with a measured drive's reading about its mean; else as it is.

    Args:
        design: the experiment.
        gain: at which the motor's angle stays as it is [rad per unit of the reading].
    """
    if "gain" not in design.unknowns:
        return design

    def build(p: Mapping[str, ArrayLike]) -> AbstractTorsionPendulum:
        made = design.build(p)
        drive = made.drive
        assert isinstance(drive, PiecewiseCubicDrive)
        inside = (drive.knots >= design.ts[0]) & (drive.knots <= design.ts[-1])
        last = np.asarray(drive.coefficients[-1])  # the reading at the start of each piece
        mean = float(np.mean(last[np.asarray(inside)[:-1]]))
        centred = drive.coefficients.at[-1].add(-mean)
        return eqx.tree_at(
            lambda m: (m.drive.offset, m.drive.coefficients),
            made,
            (drive.offset + gain * mean, centred),
        )

    return Design(design.label, design.ts, design.y0, build, design.unknowns, design.sigma)
