"""Angles whose reading starts anew after a turn: how they are told, and after how much they do."""

import math
from dataclasses import dataclass

import numpy as np

from tp_jax.recordings.gaps import LONGEST_STEP
from tp_jax.recordings.short import short_fields

_USUAL_PERIODS = (
    2.0 * math.pi,
    math.pi,
    360.0,
    180.0,
    400.0,
    1.0,
    1000.0,
    *(2.0**bits for bits in range(8, 25)),
    *(10.0**n for n in range(4, 7)),
    3600.0,
    36000.0,
)
"""Periods after which sensors start anew: a turn in radians, degrees, gons or turns, or counts."""


@dataclass(frozen=True)
class WrapPolicy:
    """Conditions under which leaps of an angle are taken for a reading that starts anew.

    Attributes:
        leap: of the angle's whole span that a leap must be at least; a motion that is sampled six
            times in a period makes half of it.
        apart: times that the smallest leap must exceed the largest other step.
        spread: of the period that the leaps may differ by among themselves.
        usual: part by which the period may be off one of the usual ones, and is then taken for it.
        least: rad or file's units; smaller leaps are a quantum of the sensor.
    """

    leap: float = 0.5
    apart: float = 3.0
    spread: float = 0.05
    usual: float = 0.02
    least: float = 0.5


@dataclass(frozen=True)
class Leaps:
    """Leaps of an angle.

    Attributes:
        period: after which the reading starts anew, in the angle's unit; None: the leaps come
            back at once, or are of different sizes, as where readings failed.
        at: indices of the samples after them.
        size: of the first leap, in the angle's unit.
    """

    __repr__ = short_fields

    period: float | None
    at: np.ndarray
    size: float


def leaps(t: np.ndarray, angle: np.ndarray, policy: WrapPolicy | None = None) -> Leaps | None:
    """Leaps that stand out of the other steps of an angle; None where there are none.

    Args:
        t: (n,) rising times; what happens in gaps is left out.
        angle: (n,) readings in any unit.
        policy: what counts as a leap.
    """
    policy = policy or WrapPolicy()
    steps, ways = np.diff(t), np.diff(angle)
    if not ways.size:
        return None
    side_by_side = steps < LONGEST_STEP * np.median(steps)
    size = np.where(side_by_side, np.abs(ways), 0.0)
    far = size > max(policy.leap * float(np.ptp(angle)), policy.least)
    if not far.any():
        return None
    rest = float(size[~far].max(initial=0.0))
    if size[far].min() <= policy.apart * rest:
        return None
    at = np.flatnonzero(far)
    # what the angle does meanwhile is what it does before and after
    near = np.where(far, np.nan, ways)
    beside = np.nan_to_num(
        np.nanmean(
            np.stack([np.r_[np.nan, near[:-1]], np.r_[near[1:], np.nan], np.zeros_like(near)]),
            axis=0,
        )
    )
    periods = np.abs(ways[at] - 1.5 * beside[at])
    period = float(np.median(periods))
    named = min(_USUAL_PERIODS, key=lambda usual: abs(period / usual - 1.0))
    usual = abs(period / named - 1.0) < policy.usual
    alike = float(np.ptp(periods)) <= policy.spread * period + 2.0 * rest
    back = np.sum((np.diff(at) <= 2) & (np.diff(np.sign(ways[at])) != 0)) * 2 >= at.size
    starts_anew = alike and (usual or not back)
    return Leaps((named if usual else period) if starts_anew else None, at + 1, float(size[at[0]]))


def whole_numbers(angle: np.ndarray) -> bool:
    """True if all readings are whole numbers, and not just a few of them: counts of an encoder."""
    return bool(np.all(angle == np.rint(angle))) and np.unique(angle).size > 20
