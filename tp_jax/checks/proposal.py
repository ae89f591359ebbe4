"""A campaign.toml for a folder of files of unknown make, to be corrected by the user."""

import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tp_jax.checks.harmonics import end_of, fit, refined, strongest
from tp_jax.checks.survey import Survey, survey
from tp_jax.recordings import CampaignError

NOT_DATA = {
    ".toml", ".md", ".json", ".html", ".py", ".ipynb", ".png", ".jpg", ".jpeg", ".svg", ".pdf",
    ".yaml", ".yml", ".ini", ".cfg", ".log", ".zip", ".docx", ".m",
}  # fmt: skip
"""Ends of names of files that hold no recording."""

STEADY = 0.6
"""Part of the largest swing that the last third of a run has at least where a motor runs.

A decay keeps less, unless it is recorded for a few swings only; the user reads what was taken.
"""

_FEWEST = 60
"""Rows by which a motion is told."""

_DECAYS = ("decay", "free", "frei", "ausschwing", "abkling", "release")
"""Words in the name of a file that speak of a decay."""


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
    for file in sorted(folder.iterdir()):
        if not file.is_file() or file.name.startswith(".") or file.suffix.lower() in NOT_DATA:
            continue
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
    first = found[0][1]
    same = [pair for pair in found if _alike(pair[1], first)]
    for file, _ in found:
        if file not in [each for each, _ in same]:
            left_out.append(
                f"Left out: {file}: its columns differ from those of {found[0][0].name}; give it a "
                "folder and a campaign.toml of its own."
            )
    surveys = [seen for _, seen in same]
    told = [*left_out, *(f"{note}." for seen in surveys for note in seen.notes)]
    return "\n".join([*_head(folder, surveys), *_entries(same)]) + "\n", told


def _alike(one: Survey, other: Survey) -> bool:
    places = [[s.column for s in each.sources.values()] for each in (one, other)]
    return places[0] == places[1] and one.delimiter == other.delimiter


def _head(folder: Path, surveys: Sequence[Survey]) -> list[str]:
    first = surveys[0]
    name = json.dumps(folder.resolve().name or "campaign", ensure_ascii=False)
    lines = [
        f"name = {name}",
        "",
        "# What follows was found in the files. Correct what is wrong, then run tp-jax check.",
        "",
        "[rig]",
        "# B1 = 1.2e-3  # kg m^2, inertia of the column, from CAD; fixes the scale of torques",
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


def _entries(found: Sequence[tuple[Path, Survey]]) -> list[str]:
    lines = []
    for file, seen in found:
        lines += ["", "[[recording]]", f"file = {json.dumps(file.name, ensure_ascii=False)}"]
        moves = _motion(seen)
        decay = any(word in file.name.lower() for word in _DECAYS)
        if moves is None and not decay:
            lines.append(
                "forced = false  # its rows do not tell; write forced = true and its omega if the "
                "motor ran"
            )
        elif decay or moves is None or moves.lasts < STEADY:
            keeps = "" if moves is None else f"  # it keeps {moves.lasts:.0%} of its swing: a free "
            lines.append(f"forced = false{keeps and keeps + 'decay?'}")
        else:
            lines.append("forced = true")
            lines.append(
                f"omega = {moves.omega:.6g}  # rad/s, as it moves ({moves.share:.0%} of it); write "
                "what was commanded"
            )
    return lines


class _Motion(NamedTuple):
    """Frequency [rad/s] of a run, its share of the end, and the part of the swing that lasts."""

    omega: float
    share: float
    lasts: float


def _motion(seen: Survey) -> _Motion | None:
    """How the longest part of a run moves whose times rise; None: it is too short."""
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
