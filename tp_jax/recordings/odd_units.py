"""Files whose angles are in another unit than those of the others, told by their noise.

A rig has the same sensors in all its runs, so that their noise is the same in radians: where that
of one file is 57 times that of the others, it is in degrees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tp_jax.recordings.encoder import whole_numbers
from tp_jax.recordings.held import held
from tp_jax.recordings.noise import noise_level, noise_level_and_error
from tp_jax.recordings.recorded_run import RecordedRun
from tp_jax.recordings.units import ANGLE

NAMES: Mapping[str | None, str] = {
    "rad": "radians",
    "deg": "degrees",
    "gon": "gons",
    "mrad": "milliradians",
    "turn": "turns",
    None: "counts of an encoder",
}
"""Units in words."""

UNITS = ("rad", "deg", "gon", "mrad", "turn")
"""Units of angles, each by one name."""


@dataclass(frozen=True)
class OddPolicy:
    """Conditions under which noise tells of another unit.

    Attributes:
        apart: factor between neighbouring levels of noise from which they are of two groups.
        near: factor by which a ratio may miss that of two units.
        rarer: times that sensors in degrees are as frequent as those in gons; a ratio must tell
            them, which are 1.11 degrees, apart by more.
        steady: times that the level of every other sample may be that of all; of what was computed,
            without noise, some motion is left, four times as much and more.
        samples: of a recording that are looked at.
    """

    apart: float = 3.0
    near: float = 1.15
    rarer: float = 20.0
    steady: float = 2.0
    samples: int = 2500


POLICY = OddPolicy()


@dataclass(frozen=True)
class Odd:
    """A channel of a recording that is in another unit than the other recordings.

    Attributes:
        unit: name of it; None: counts of an encoder.
        ratio: of its noise to that of the others.
        perhaps: a unit that the ratio does not exclude.
    """

    unit: str | None
    ratio: float
    perhaps: str | None = None

    @property
    def named(self) -> str:
        """The unit in words, "degrees"."""
        other = f" (or {NAMES[self.perhaps]}, the noise does not tell)" if self.perhaps else ""
        return NAMES[self.unit] + other


def odd_units(
    recordings: Sequence[RecordedRun], policy: OddPolicy = POLICY
) -> dict[str, dict[str, Odd]]:
    """Label of a recording -> channel -> what it is in, for those that are in another unit."""
    found: dict[str, dict[str, Odd]] = {}
    for channel in ("phi1", "phi2"):
        levels = levels_of(recordings, channel, policy)
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
    for mine in found.values():
        # two sensors of one file: where one is known to be in degrees, or they differ, both are
        if len(mine) == 2 and {each.unit for each in mine.values()} <= {"deg", "gon"}:
            if any(each.unit == "deg" for each in mine.values()):
                sure = any(each == Odd("deg", each.ratio) for each in mine.values())
                perhaps = None if sure else "gon"
                mine.update({n: Odd("deg", each.ratio, perhaps) for n, each in mine.items()})
    return found


def _has_noise(recording: RecordedRun, channel: str, level: float, policy: OddPolicy) -> bool:
    """True if a level is that of noise, which is the same among every other sample."""
    part = slice(0, policy.samples, 2)
    other = noise_level(recording.t[part], recording.channels[channel][part])
    return other < policy.steady * level


def _odd(
    recording: RecordedRun,
    channel: str,
    level: tuple[float, float],
    usual: tuple[float, float],
    policy: OddPolicy,
) -> Odd | None:
    ratio = level[0] / usual[0]
    if 1.0 / policy.apart < ratio < policy.apart:
        return None
    if not _has_noise(recording, channel, level[0], policy):
        return None
    factor = declared(recording, channel)
    if whole_numbers(np.asarray(recording.channels[channel]) / factor):
        return Odd(None, ratio)
    off = {unit: abs(float(np.log(ratio * ANGLE[unit] / factor))) for unit in UNITS}
    unit = min(UNITS, key=lambda each: off[each])
    if off[unit] > np.log(policy.near) or ANGLE[unit] == factor:
        return None
    if unit not in ("deg", "gon"):
        return Odd(unit, ratio)
    gon = (off["deg"] ** 2 - off["gon"] ** 2) / (2.0 * (level[1] ** 2 + usual[1] ** 2))
    if gon > np.log(policy.rarer):
        return Odd("gon", ratio)
    return Odd("deg", ratio, "gon" if gon > -np.log(policy.rarer) else None)


def declared(recording: RecordedRun, channel: str) -> float:
    """rad in the unit that a channel is said to be in."""
    source = recording.sources.get(channel)
    return 1.0 if source is None else abs(source.factor(channel) / source.scale)


def advice(recording: RecordedRun, odd: Mapping[str, str | None]) -> str:
    """Says what to write for one file, by the unit of each channel; None: counts of an encoder."""
    told = ", ".join(
        f"{channel} = {{ counts = N }}" if unit is None else f'{channel} = {{ unit = "{unit}" }}'
        for channel, unit in odd.items()
    )
    turn = ", N those of a whole turn" if None in odd.values() else ""
    return f'write columns = {{ {told} }} beside file = "{recording.name}"{turn}'


def levels_of(
    recordings: Sequence[RecordedRun], channel: str, policy: OddPolicy = POLICY
) -> dict[str, tuple[float, float]]:
    """Label -> noise and its relative error, of those that have some.

    Steps of readings that are held are none: they go with the motion.
    """
    out = {}
    for each in recordings:
        x = each.channels.get(channel)
        if x is None or each.n < 50 or held(x) is not None:
            continue
        part = slice(policy.samples)
        level, error = noise_level_and_error(each.t[part], x[part])
        if level > 0.0:
            out[each.label] = level, error
    return out


def _usual(levels: Sequence[tuple[float, float]], policy: OddPolicy) -> list[tuple[float, float]]:
    """The medians of the largest groups of rising levels, and their relative errors."""
    groups: list[list[tuple[float, float]]] = []
    for level in levels:
        if not groups or level[0] > policy.apart * groups[-1][-1][0]:
            groups.append([])
        groups[-1].append(level)
    most = max(map(len, groups), default=0)
    return [
        (float(np.median([x for x, _ in each])), float(np.mean([e for _, e in each]) / most**0.5))
        for each in groups
        if len(each) == most
    ]
