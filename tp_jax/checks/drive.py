"""Checks that a forced run moves at its drive's frequency: units of times and frequencies."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tp_jax.checks import time_units
from tp_jax.checks.finding import Finding
from tp_jax.checks.harmonics import end_of, fit, strongest
from tp_jax.checks.policy import DrivePolicy
from tp_jax.recordings import Recording
from tp_jax.recordings.units import FREQUENCY


@dataclass(frozen=True)
class Mistake:
    """A unit taken for another.

    Attributes:
        seen: frequency of the motion in the file, over that said; None: 2π over the square of it.
        wrong: what it is, as part of a sentence; {omega} is what was said, {right} what it is
            in rad/s.
        mend: what to write.
        wrong_of_all, mend_of_all: the same of several runs, which may differ in their numbers.
    """

    seen: float | None
    wrong: str
    mend: str
    wrong_of_all: str
    mend_of_all: str


_LISTED = 3
"""Numbers that a sentence of several runs shows."""

_T = (
    ' for t under [format.columns], as in t = {{ unit = "{unit}" }}, with its column if one stands '
    "there"
)


def _times(recording: Recording) -> list[Mistake]:
    """Units of times but for the one that was said, in the file's header or by the user."""
    source = time_units.source_of(recording)
    found = []
    for unit, seen in time_units.others(source).items():
        wrong = f"the times are in {time_units.NAMES[unit]}"
        mend = f'write unit = "{unit}"' + _T.replace("{unit}", unit) + time_units.in_place(source)
        found.append(Mistake(seen, wrong, mend, wrong, mend))
    return found


ONE_FILE = " (for a single file without a campaign.toml: --omega {right:.6g})"
"""Follows what is to be written in a campaign.toml."""


def _frequency(unit: str, name: str) -> Mistake:
    return Mistake(
        FREQUENCY[unit],
        f"omega = {{omega:g}} is in {name}",
        f'write omega = {{right:.6g}}, or unit = "{unit}" beside it{ONE_FILE}',
        f"omega is in {name}",
        f'write unit = "{unit}" beside each omega',
    )


FREQUENCIES = (
    _frequency("Hz", "Hz"),
    _frequency("rpm", "turns a minute"),
    _frequency("deg/s", "degrees a second"),
    Mistake(
        None,
        "omega = {omega:g} is a period in seconds",
        "write period = {omega:g} in place of omega" + ONE_FILE,
        "omega is a period in seconds",
        "write period in place of omega, with the same number",
    ),
)


@dataclass(frozen=True)
class Driven:
    """Signs of its drive in a forced run.

    Attributes:
        recording: the run.
        share: of phi1's variance at the frequency said, with harmonics.
        mistake: the unit that explains it; None: none does.
        moves_at: rad/s, frequency of the motion where the share is low; NaN elsewhere.
        steady: whether the motion at that frequency is what the run was driven at.
    """

    recording: Recording
    share: float
    mistake: Mistake | None = None
    moves_at: float = math.nan
    steady: bool = False


def shares(recordings: Sequence[Recording], policy: DrivePolicy) -> list[Driven]:
    """Looks at every forced run whose frequency is said."""
    forced = [r for r in recordings if r.forced and r.omega is not None]
    return [_look(recording, policy) for recording in forced]


def findings(driven: Sequence[Driven], policy: DrivePolicy) -> list[Finding]:
    """Finds faults and doubts about frequencies, one finding for runs with the same fault."""
    by_mistake: dict[Mistake, list[Driven]] = defaultdict(list)
    found = []
    for each in driven:
        omega = each.recording.omega
        if each.share >= policy.right or omega is None:
            continue
        if each.mistake is not None:
            by_mistake[each.mistake].append(each)
            continue
        numbers = {"share": each.share, "moves_at": each.moves_at}
        about = f"{each.moves_at:.4g}"
        if each.share < policy.wrong and each.steady:
            found.append(
                Finding(
                    "frequency",
                    "wrong",
                    (each.recording.label,),
                    f"phi1 moves at {about} rad/s and not at its omega of {omega:.4g}",
                    f"write omega = {about} if that is what it was driven at"
                    f"{ONE_FILE.format(right=float(about))}, or name the right file",
                    numbers,
                )
            )
            continue
        moves = f", most is at {about} rad/s" if math.isfinite(each.moves_at) else ""
        found.append(
            Finding(
                "frequency",
                "doubtful",
                (each.recording.label,),
                f"only {each.share:.0%} of phi1's motion is at its omega of {omega:.4g} "
                f"rad/s{moves}",
                "see whether omega, the file and the time's unit are right",
                numbers,
            )
        )
    return [_same(mistake, runs) for mistake, runs in by_mistake.items()] + found


def _same(mistake: Mistake, runs: Sequence[Driven]) -> Finding:
    omega = runs[0].recording.omega or 0.0
    right = omega * (mistake.seen or 2.0 * math.pi / omega / omega)
    told = {"omega": omega, "right": right}
    several = len(runs) > 1
    wrong = mistake.wrong_of_all if several else mistake.wrong
    mend = mistake.mend_of_all if several else mistake.mend
    moves, said = _listed([r.moves_at for r in runs]), _listed([r.recording.omega for r in runs])
    at = f"phi1 moves at {moves} rad/s where omega is {said}, so that "
    return Finding(
        "units",
        "wrong",
        tuple(run.recording.label for run in runs),
        at + wrong.format(**told),
        mend.format(**told),
        {"share": max(run.share for run in runs), "moves_at": runs[0].moves_at},
    )


def _listed(values: Sequence[float | None]) -> str:
    """The first three different numbers."""
    texts = list(dict.fromkeys(f"{value:.4g}" for value in values if value is not None))
    return ", ".join([*texts[:_LISTED], *(["..."] if len(texts) > _LISTED else [])])


def _look(recording: Recording, policy: DrivePolicy) -> Driven:
    omega = recording.omega or 0.0
    part = end_of(recording.t, policy.part)
    t, x = recording.t[part], recording.phi1[part]
    # harmonics of a frequency that has hardly a period there fit any motion
    few = omega * (t[-1] - t[0]) < 2.0 * math.pi * policy.periods
    share = fit(t, x, omega, 1 if few else policy.harmonics).share
    if share >= policy.right:
        own = share if few else fit(t, x, omega, 1).share
        if own >= policy.fundamental:
            return Driven(recording, share)
        share = own  # it moves at a harmonic of what is said, at half or a third of its omega
    at = strongest(t, x)
    times = round(at / omega) if omega and math.isfinite(at) else 0
    if times > 1 and abs(at / (times * omega) - 1.0) < policy.near:
        at = times * omega
    found = []
    for mistake in (*_times(recording), *FREQUENCIES):
        meant = omega * (mistake.seen or 2.0 * math.pi / omega / omega)
        fastest = math.pi / float(np.median(np.diff(t)))
        if meant * (t[-1] - t[0]) < 2.0 * math.pi * policy.periods or meant > fastest:
            continue
        for tried in [meant] + ([at] if abs(at / meant - 1.0) < policy.near else []):
            found.append((fit(t, x, tried, policy.harmonics).share, tried, mistake))
    best = max(found, key=lambda each: each[0], default=None)
    if share < policy.wrong and best is not None and best[0] >= policy.other:
        return Driven(recording, share, best[2], best[1])
    whole = fit(t, x, at, policy.harmonics)
    half = t.size // 2
    first, second = (
        abs(fit(t[s], x[s], at, policy.harmonics).amplitude)
        for s in (slice(half), slice(half, None))
    )
    stays = abs(second / first - 1.0) < policy.steady if first else False
    far = abs(at / omega - 1.0) > 0.2
    return Driven(recording, share, None, at, whole.share >= policy.other and stays and far)
