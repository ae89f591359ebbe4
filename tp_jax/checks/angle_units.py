"""Angles in another unit than they are said to be: of one file, or of one column in all files.

Of a file the noise tells it, beside that of the others (`recordings.odd_units`). Of a column the
rider does: friction puts H = phi2/phi1 on a half circle, where |H| = -cos(arg H), and phi2 in
degrees puts it 57 times as far, in the same direction.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tp_jax.checks.drive import Driven
from tp_jax.checks.finding import Finding, Level
from tp_jax.checks.policy import DrivePolicy, RiderPolicy, UnitPolicy
from tp_jax.checks.rider import Dragged, dragged
from tp_jax.recordings import Recording, noise_level
from tp_jax.recordings.odd_units import NAMES, POLICY, Odd, advice, declared, levels_of, odd_units
from tp_jax.recordings.units import ANGLE


@dataclass(frozen=True)
class Looked:
    """Result of a look at the units of angles.

    Attributes:
        findings: one for each file, or for a column of all files.
        labels: of the recordings they are about, whose rider tells nothing else.
    """

    findings: list[Finding]
    labels: frozenset[str]


def look(
    recordings: Sequence[Recording],
    driven: Sequence[Driven],
    drive: DrivePolicy,
    rider: RiderPolicy,
    policy: UnitPolicy,
) -> Looked:
    """Looks at the units of all angles."""
    runs = dragged(driven, drive, rider, moving=0.0)
    scales = {run.recording.label: each for run in runs if (each := scale_of(run.h, policy))}
    seen = odd_units(recordings)
    found = {
        each.label: odd
        for each in recordings
        if (odd := seen.get(each.label)) and _certain(each, odd, scales.get(each.label), policy)
    }
    large = {
        run.recording.label: unit
        for run in runs
        if run.recording.label not in found
        and (unit := _large(run, scales.get(run.recording.label), policy)) is not None
    }
    rest = {label for label in scales if label not in large and label not in found}
    whole = None
    if not found and not large:
        whole = _finer(recordings, scales, policy)
    elif not found and len({*large.values()}) == 1 and (not rest or _one_noise(recordings)):
        whole = _of_column("phi2", next(iter(large.values())), recordings)
    if whole is not None:
        return Looked([whole], frozenset(each.label for each in recordings))
    for label, unit in large.items():
        found[label] = {"phi2": Odd(unit, scales[label])}
    findings = [
        _of_file(each, found[each.label], "wrong", "rider" if each.label in large else "noise")
        for each in recordings
        if each.label in found
    ]
    findings += [
        _of_file(each, seen[each.label], "doubtful", "noise")
        for each in recordings
        if each.label in seen and each.label not in found
    ]
    return Looked(findings, frozenset(found))


def scale_of(h: complex, policy: UnitPolicy) -> float | None:
    """Returns |H| over what it should be in its direction; None: it does not tell."""
    if h == 0.0 or h.imag > policy.above * abs(h):
        return None
    right = -h.real / abs(h)
    return abs(h) / right if right > policy.clear else None


def _one_noise(recordings: Sequence[Recording]) -> bool:
    """True if phi2 has the same noise in all files, and is in one unit then, known or not."""
    levels = [level for level, _ in levels_of(recordings, "phi2").values()]
    return len(levels) == len(recordings) and max(levels) < POLICY.apart * min(levels)


def _certain(
    recording: Recording, odd: Mapping[str, Odd], scale: float | None, policy: UnitPolicy
) -> bool:
    """True if noise that is another suffices: somewhat less of it may be that of a body at rest."""

    def moves(channel: str) -> bool:
        x = recording.channels[channel]
        return float(np.std(x)) > policy.at_rest * noise_level(recording.t, x)

    if all(
        each.ratio > 1.0 or each.ratio < 1.0 / policy.at_rest or moves(channel)
        for channel, each in odd.items()
    ):
        return True
    if len(odd) == 2 and len({each.unit for each in odd.values()}) == 1:
        return True
    if scale is None:
        return False
    told = {"phi2": scale, "phi1": 1.0 / scale}
    return all(
        abs(math.log(told[channel] / each.ratio)) < math.log(policy.near)
        for channel, each in odd.items()
    )


def _large(run: Dragged, scale: float | None, policy: UnitPolicy) -> str | None:
    """The unit of phi2 by its rider, where that is smaller than a radian."""
    if scale is None or scale < policy.larger:
        return None
    factor = declared(run.recording, "phi2")
    fits = [
        unit
        for unit in ("deg", "gon", "mrad")  # degrees, where gons are as likely
        if abs(math.log(scale * ANGLE[unit] / factor)) < math.log(policy.near)
    ]
    return fits[0] if fits else None


def _finer(
    recordings: Sequence[Recording], scales: Mapping[str, float], policy: UnitPolicy
) -> Finding | None:
    """phi1 of all files: the rider goes a 57th as far, and phi2 has a 57th of the noise."""
    noise = [_noise_ratio(each) for each in recordings if each.phi2 is not None]
    for unit in ("deg", "gon", "mrad"):
        wanted = ANGLE[unit] / declared(recordings[0], "phi1")
        if wanted * policy.larger > 1.0:
            continue

        def alike(values: Iterable[float], factor: float, wanted: float = wanted) -> bool:
            return all(
                each > 0.0 and abs(math.log(each / wanted)) < math.log(factor) for each in values
            )

        if scales and alike(scales.values(), policy.near) and alike(noise, policy.alike):
            return _of_column("phi1", unit, recordings)
    return None


def _noise_ratio(recording: Recording) -> float:
    """phi2's noise over phi1's; 0 where it is not known."""
    t = recording.t
    one, two = (noise_level(t, x) for x in recording.channels.values())
    return two / one if one > 0.0 else 0.0


def _of_column(channel: str, unit: str, recordings: Sequence[Recording]) -> Finding:
    return Finding(
        "units",
        "wrong",
        tuple(each.label for each in recordings),
        f"{channel} looks in {NAMES[unit]}, by the half circle on which friction puts the rider",
        f'write unit = "{unit}" for {channel} under [format.columns]',
    )


def _of_file(recording: Recording, odd: Mapping[str, Odd], level: Level, by: str) -> Finding:
    first, *more = odd
    names = " and ".join([first, *more])
    told = " and ".join(dict.fromkeys(each.named for each in odd.values()))
    verb = ("are" if more else "is") if level == "wrong" else "may be"
    ratio = odd[first].ratio
    size = f"{ratio:.3g} times too large" if ratio > 1.0 else f"{1 / ratio:.3g} times too small"
    mend = advice(recording, {channel: each.unit for channel, each in odd.items()})
    return Finding(
        "units",
        level,
        (recording.label,),
        f"{names} {verb} in {told} and not as in the other recordings, {size} by the {by}",
        mend if level == "wrong" else f"{mend} if so",
        {f"ratio_{channel}": each.ratio for channel, each in odd.items()},
    )
