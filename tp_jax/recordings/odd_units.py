"""Files whose angles are in another unit than those of the others, told by their noise.

A rig has the same sensors in all its runs, so that their noise is the same in radians: where that
of one file is 57 times that of the others, it is in degrees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tp_jax.recordings.encoder import whole_numbers
from tp_jax.recordings.noise import noise_level
from tp_jax.recordings.recording import Recording
from tp_jax.recordings.units import ANGLE

NAMES: Mapping[str | None, str] = {
    "rad": "radians", "deg": "degrees", "gon": "gons", "mrad": "milliradians", "turn": "turns",
    None: "counts of an encoder",
}  # fmt: skip
"""Units in words."""

UNITS = ("rad", "deg", "gon", "mrad", "turn")
"""What angles are in, each by one name; degrees are right where gons are as likely."""


@dataclass(frozen=True)
class OddPolicy:
    """When noise tells of another unit.

    Attributes:
        apart: factor between neighbouring levels of noise from which they are of two groups.
        near: factor by which a ratio may miss that of two units; levels of 2500 samples are known
            to 3 %, and gons are 1.11 degrees.
        steady: times that the level of every other sample may be that of all; of what was computed,
            without noise, some motion is left, four times as much and more.
        samples: of a recording that are looked at.
    """

    apart: float = 3.0
    near: float = 1.15
    steady: float = 2.0
    samples: int = 2500


POLICY = OddPolicy()


@dataclass(frozen=True)
class Odd:
    """A channel of a recording that is in another unit than the other recordings.

    Attributes:
        unit: name of it; None: counts of an encoder.
        ratio: of its noise to that of the others.
    """

    unit: str | None
    ratio: float


def odd_units(
    recordings: Sequence[Recording], policy: OddPolicy = POLICY
) -> dict[str, dict[str, Odd]]:
    """Label of a recording -> channel -> what it is in, for those that are in another unit."""
    found: dict[str, dict[str, Odd]] = {}
    for channel in ("phi1", "phi2"):
        levels = _levels(recordings, channel, policy)
        known = [each for each in recordings if each.label in levels]
        # of two groups that are as large either may be the one that is right
        for usual in _usual(sorted(levels.values()), policy):
            odd = {
                each.label: _odd(each, channel, levels[each.label], usual, policy) for each in known
            }
            if any(odd.values()):
                for label, each in odd.items():
                    if each is not None:
                        found.setdefault(label, {})[channel] = each
                break
    return found


def _has_noise(recording: Recording, channel: str, level: float, policy: OddPolicy) -> bool:
    """Whether a level is that of noise, which is the same among every other sample."""
    part = slice(0, policy.samples, 2)
    other = noise_level(recording.t[part], recording.channels[channel][part])
    return other < policy.steady * level


def _odd(
    recording: Recording, channel: str, level: float, usual: float, policy: OddPolicy
) -> Odd | None:
    ratio = level / usual
    if 1.0 / policy.apart < ratio < policy.apart:
        return None
    if not _has_noise(recording, channel, level, policy):
        return None
    factor = declared(recording, channel)
    if whole_numbers(np.asarray(recording.channels[channel]) / factor):
        return Odd(None, ratio)
    unit = unit_of_ratio(ratio, factor, policy.near)
    return None if unit is None else Odd(unit, ratio)


def declared(recording: Recording, channel: str) -> float:
    """rad in the unit that a channel is said to be in."""
    source = recording.sources.get(channel)
    return 1.0 if source is None else abs(source.factor(channel) / source.scale)


def unit_of_ratio(ratio: float, factor: float, near: float) -> str | None:
    """The unit in which readings are `ratio` times what they would be in one of `factor` rad."""
    off = {unit: abs(np.log(ratio * ANGLE[unit] / factor)) for unit in UNITS}
    unit = min(UNITS, key=lambda each: off[each])
    return unit if off[unit] < np.log(near) and ANGLE[unit] != factor else None


def advice(recording: Recording, odd: Mapping[str, str | None]) -> str:
    """What to write for one file, by the unit of each channel; None: counts of an encoder."""
    told = ", ".join(
        f"{channel} = {{ counts = N }}" if unit is None else f'{channel} = {{ unit = "{unit}" }}'
        for channel, unit in odd.items()
    )
    turn = ", N those of a whole turn" if None in odd.values() else ""
    return f'write columns = {{ {told} }} beside file = "{recording.name}"{turn}'


def _levels(recordings: Sequence[Recording], channel: str, policy: OddPolicy) -> dict[str, float]:
    """Label -> noise, of those that have some."""
    out = {}
    for each in recordings:
        x = each.channels.get(channel)
        if x is None or each.n < 50:
            continue
        part = slice(policy.samples)
        level = noise_level(each.t[part], x[part])
        if level > 0.0:
            out[each.label] = level
    return out


def _usual(levels: Sequence[float], policy: OddPolicy) -> list[float]:
    """The medians of the largest groups of rising levels."""
    groups: list[list[float]] = []
    for level in levels:
        if not groups or level > policy.apart * groups[-1][-1]:
            groups.append([])
        groups[-1].append(level)
    most = max(map(len, groups), default=0)
    return [float(np.median(each)) for each in groups if len(each) == most]
