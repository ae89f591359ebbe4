"""A campaign.toml for a folder of files of unknown make, to be corrected by the user."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tp_jax.checks.harmonics import end_of, fit, refined, strongest
from tp_jax.checks.survey import Survey, survey
from tp_jax.recordings import CampaignError
from tp_jax.recordings.sources import ColumnSource

NOT_DATA = {
    ".toml", ".md", ".json", ".html", ".py", ".ipynb", ".png", ".jpg", ".jpeg", ".svg", ".pdf",
    ".yaml", ".yml", ".ini", ".cfg", ".log", ".zip", ".docx", ".m",
}  # fmt: skip
"""Ends of names of files that hold no recording."""

STEADY = 0.6
"""Part of the largest swing that the last third of a run has at least where a motor runs.

A decay keeps less, unless it is recorded for a few swings only; the user reads what was taken.
"""

_DECAYS = ("decay", "free", "frei", "ausschwing", "abkling", "release")
"""Words in the name of a file that speak of a decay."""


def propose(folder: Path) -> tuple[str, list[str]]:
    """The text of a campaign.toml for the data files of a folder.

    Args:
        folder: with the data files, and no campaign.toml.

    Returns:
        The text, and a sentence for each file that was left out.

    Raises:
        CampaignError: no file in it can be read.
    """
    found: list[tuple[Path, Survey]] = []
    left_out = []
    for file in sorted(folder.iterdir()):
        if not file.is_file() or file.name.startswith(".") or file.suffix.lower() in NOT_DATA:
            continue
        try:
            found.append((file, survey(file)))
        except CampaignError as fault:
            left_out.append(str(fault))
    if not found:
        raise CampaignError(
            folder,
            left_out[0].rstrip(".?") if left_out else "there is no data file in it",
            "put the recordings there, a file for each run",
        )
    first = found[0][1]
    same = [pair for pair in found if _alike(pair[1], first)]
    for file, _ in found:
        if file not in [each for each, _ in same]:
            left_out.append(
                f"{file}: its columns differ from those of {found[0][0].name}; give it a folder "
                "and a campaign.toml of its own."
            )
    return "\n".join([*_head(folder, first), *_entries(same)]) + "\n", left_out


def _alike(one: Survey, other: Survey) -> bool:
    places = [[s.column for s in each.sources.values()] for each in (one, other)]
    return places[0] == places[1] and one.delimiter == other.delimiter


def _head(folder: Path, first: Survey) -> list[str]:
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
    lines += ["", "[format.columns]"]
    lines += [_column(name, source, first.why[name]) for name, source in first.sources.items()]
    return lines


def _column(name: str, source: ColumnSource, why: str) -> str:
    column = json.dumps(source.column, ensure_ascii=False)
    parts = [f"column = {column}"]
    if source.unit is not None:
        parts.append(f'unit = "{source.unit}"')
    if source.counts is not None:
        parts.append(f"counts = {source.counts:g}")
    if source.wrap is not None:
        parts.append(f"wrap = {source.wrap:.10g}")
    return f"{name} = {{ {', '.join(parts)} }}" + (f"  # {why}" if why else "")


def _entries(found: Sequence[tuple[Path, Survey]]) -> list[str]:
    lines = []
    for file, seen in found:
        lines += ["", "[[recording]]", f"file = {json.dumps(file.name, ensure_ascii=False)}"]
        omega, share, lasts = _motion(seen)
        if any(word in file.name.lower() for word in _DECAYS) or not lasts >= STEADY:
            lines.append(f"forced = false  # it keeps {lasts:.0%} of its swing: a free decay?")
        else:
            lines.append("forced = true")
            lines.append(
                f"omega = {omega:.6g}  # rad/s, as it moves ({share:.0%} of it); write what was "
                "commanded"
            )
    return lines


def _motion(seen: Survey) -> tuple[float, float, float]:
    """Frequency [rad/s], its share of the motion's end, and the part of the swing that lasts."""
    t, x = seen.t, seen.phi1
    if t.size < 60 or not np.all(np.diff(t) > 0.0) or not np.isfinite(x).all():
        return math.nan, 0.0, math.nan
    thirds = [float(np.std(part)) for part in np.array_split(x, 3)]
    end = end_of(t, 0.6)
    omega = refined(t[end], x[end], strongest(t[end], x[end]))
    lasts = thirds[-1] / max(thirds) if max(thirds) else math.nan
    return omega, fit(t[end], x[end], omega).share, lasts
