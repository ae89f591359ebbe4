"""A campaign.toml for a folder of files of unknown make, to be corrected by the user.

data_files -> survey of each -> alike -> written      with what the user answered, if anything
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from tp_jax.checks.harmonics import end_of, fit, refined, strongest
from tp_jax.checks.survey import Survey, survey
from tp_jax.recordings import CampaignError

NOT_DATA = {
    ".toml",
    ".md",
    ".json",
    ".html",
    ".py",
    ".ipynb",
    ".png",
    ".jpg",
    ".jpeg",
    ".svg",
    ".pdf",
    ".yaml",
    ".yml",
    ".ini",
    ".cfg",
    ".log",
    ".zip",
    ".docx",
    ".m",
}
"""Ends of names of files that hold no recording."""

STEADY = 0.6
"""Part of the largest swing that the last third of a run has at least where a motor runs.

A decay keeps less, unless it is recorded for a few swings only; the user reads what was taken.
"""

_FEWEST = 60
"""Rows by which a motion is told."""

_DECAYS = ("decay", "free", "frei", "ausschwing", "abkling", "release")
"""Words in the name of a file that speak of a decay."""


Kind = Literal["commanded", "measured", "decay"]


@dataclass(frozen=True)
class Driven:
    """Drive of a recording.

    Attributes:
        kind: at a commanded frequency, by a drive that the file holds, or not at all.
        omega: the commanded frequency [rad/s]; None for the other kinds.
    """

    kind: Kind
    omega: float | None = None


@dataclass(frozen=True)
class Answers:
    """Answers of a user about a campaign whose files do not tell them.

    Attributes:
        B1: moment of inertia of the column [kg m^2]; None: not known.
        driven: name of a file -> how it was driven; of others it is guessed.
        unused: names of files to be left out.
        remark: a comment for the head of the campaign.toml, without its sign.
    """

    B1: float | None = None
    driven: Mapping[str, Driven] = field(default_factory=dict)
    unused: frozenset[str] = frozenset()
    remark: str = ""


def propose(folder: Path) -> tuple[str, list[str]]:
    """The text of a campaign.toml for the data files of a folder.

    Args:
        folder: with the data files, and no campaign.toml.

    Returns:
        The text, and a sentence for each file that was left out or whose rows were mended.

    Raises:
        CampaignError: no file in it can be read.
    """
    found: list[tuple[Path, Survey]] = []
    left_out: list[str] = []
    first_fault: CampaignError | None = None
    for file in data_files(folder):
        try:
            found.append((file, survey(file)))
        except CampaignError as fault:
            left_out.append(f"Left out: {fault}")
            first_fault = first_fault or fault
    if not found and first_fault is not None and first_fault.line is not None:
        raise first_fault
    if not found:
        raise CampaignError(
            folder,
            str(first_fault).rstrip(".?") if first_fault else "there is no data file in it",
            "put the recordings there, a file for each run",
        )
    same, others = alike(found)
    left_out += [f"Left out: {sentence}" for sentence in others.values()]
    told = [*left_out, *(f"{note}." for _, seen in same for note in seen.notes)]
    return written(folder, same), told


def data_files(folder: Path) -> list[Path]:
    """The files of a folder that may be recordings, by name."""
    return [file for file in sorted(folder.iterdir()) if file.is_file() and may_be_data(file.name)]


def may_be_data(name: str) -> bool:
    """True if a file of this name may be a recording."""
    return not name.startswith(".") and Path(name).suffix.lower() not in NOT_DATA


def alike(
    found: Sequence[tuple[Path, Survey]], model: tuple[Path, Survey] | None = None
) -> tuple[list[tuple[Path, Survey]], dict[Path, str]]:
    """The files with the same columns, and of the others a sentence each.

    Args:
        found: files, each with its survey.
        model: the one whose columns they have; None: one that most are like, or as many with more
            columns. A list of runs or a calibration may come first in a folder.
    """
    if model is None:
        model = max(
            found,
            key=lambda pair: (
                sum(_alike(pair[1], other) for _, other in found),
                len(pair[1].sources),
            ),
        )
    first, seen = model
    same = [pair for pair in found if _alike(pair[1], seen)]
    others = {
        file: f"{file}: its columns differ from those of {first.name}; give it a folder and a "
        "campaign.toml of its own."
        for file, other in found
        if not _alike(other, seen)
    }
    return same, others


def written(
    folder: Path, found: Sequence[tuple[Path, Survey]], answers: Answers | None = None
) -> str:
    """The text of a campaign.toml.

    Args:
        folder: that it is for.
        found: its files, all alike, each with its survey.
        answers: of the user; None: all is guessed.
    """
    answers = answers or Answers()
    used = [(file, seen) for file, seen in found if file.name not in answers.unused]
    head = _head(folder, [seen for _, seen in used or found], answers)
    return "\n".join([*head, *_entries(used, answers.driven)]) + "\n"


def guessed(file: Path, seen: Survey) -> Driven:
    """Guesses how a recording was driven."""
    return _guess(file, seen)[0]


def _alike(one: Survey, other: Survey) -> bool:
    places = [[s.column for s in each.sources.values()] for each in (one, other)]
    return places[0] == places[1] and one.delimiter == other.delimiter


def _head(folder: Path, surveys: Sequence[Survey], answers: Answers) -> list[str]:
    first = surveys[0]
    name = json.dumps(folder.resolve().name or "campaign", ensure_ascii=False)
    B1 = "# B1 = 1.2e-3" if answers.B1 is None else f"B1 = {answers.B1!r}"
    lines = [
        *([f"# {answers.remark}"] if answers.remark else []),
        f"name = {name}",
        "",
        "# What follows was found in the files. Correct what is wrong, then run tp-jax check.",
        "",
        "[rig]",
        f"{B1}  # kg m^2, inertia of the column, from CAD; fixes the scale of torques",
    ]
    if "phi2" not in first.sources:
        lines.append('model = "single"  # no second angle was found')
    lines += ["", "[format]"]
    if first.delimiter is not None:
        lines.append(f"delimiter = {json.dumps(first.delimiter)}")
    if first.decimal is not None:
        lines.append(f'decimal = "{first.decimal}"')
    if any(seen.held for seen in surveys):
        lines.append("held = true  # readings are held: of rows that repeat one the first is kept")
    lines += ["", "[format.columns]"]
    for name, source in first.sources.items():
        why = first.why[name]
        for seen in surveys if name == "t" else ():  # one clock may start anew in one file only
            other = seen.sources[name]
            if (other.wrap, other.summer_time) != (None, False):
                source = replace(source, wrap=other.wrap, summer_time=other.summer_time)
                why = seen.why[name]
                break
        lines.append(f"{name} = {source.toml()}" + (f"  # {why}" if why else ""))
    return lines


def _entries(found: Sequence[tuple[Path, Survey]], answered: Mapping[str, Driven]) -> list[str]:
    lines = []
    for file, seen in found:
        lines += ["", "[[recording]]", f"file = {json.dumps(file.name, ensure_ascii=False)}"]
        driven, why = _guess(file, seen)
        answer = answered.get(file.name, driven)
        # the reason of a guess is none for another answer
        remark = f"  # {why}" if why and _same(answer, driven) else ""
        if answer.kind == "measured":
            lines.append('drive = "measured"')
        elif answer.kind == "decay":
            lines.append(f"forced = false{remark}")
        else:
            omega = f"{answer.omega:.6g}" if answer is driven else repr(answer.omega)
            lines += ["forced = true", f"omega = {omega}{remark or '  # rad/s'}"]
    return lines


def _same(one: Driven, other: Driven) -> bool:
    """True if two say the same, to the digits that a campaign.toml gets of a guess."""
    return one.kind == other.kind and f"{one.omega or 0.0:.6g}" == f"{other.omega or 0.0:.6g}"


def _guess(file: Path, seen: Survey) -> tuple[Driven, str]:
    """Guesses how a recording was driven, and says what speaks for it."""
    moves = _motion(seen)
    decay = any(word in file.name.lower() for word in _DECAYS)
    if moves is None and not decay:
        return Driven("decay"), (
            "nothing shows how it was driven; write forced = true and its omega if the motor ran"
        )
    if decay or moves is None or moves.lasts < STEADY:
        keeps = "" if moves is None else f"guessed: {moves.lasts:.0%} of its swing is left"
        return Driven("decay"), keeps
    return Driven("commanded", moves.omega), (
        f"rad/s, guessed: {moves.share:.0%} of the motion is at it; write the commanded one"
    )


class _Motion(NamedTuple):
    """Frequency [rad/s] of a run, its share of the end, and the part of the swing that lasts."""

    omega: float
    share: float
    lasts: float


def _motion(seen: Survey) -> _Motion | None:
    """Finds how the longest part of a run with rising times moves; None: it is too short."""
    usable = np.isfinite(seen.t) & np.isfinite(seen.phi1)
    t, x = seen.t[usable], seen.phi1[usable]
    part = max(_rising(t), key=lambda each: each.stop - each.start, default=slice(0))
    t, x = t[part], x[part]
    if t.size < _FEWEST:
        return None
    thirds = [float(np.std(each)) for each in np.array_split(x, 3)]
    if not max(thirds):
        return None
    end = end_of(t, 0.6)
    omega = refined(t[end], x[end], strongest(t[end], x[end]))
    return _Motion(omega, fit(t[end], x[end], omega).share, thirds[-1] / max(thirds))


def _rising(t: np.ndarray) -> list[slice]:
    edges = [0, *(np.flatnonzero(np.diff(t) <= 0.0) + 1).tolist(), t.size]
    return [slice(a, b) for a, b in pairwise(edges)]
