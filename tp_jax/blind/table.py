"""The score for a terminal, as tables of rich."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Group
    from rich.table import Table

WORDS = {
    "top1": "cause, first named", "top1_alone": "  ties not counted as one",
    "top3": "cause, among the first three", "location": "location",
    "false_alarm": "false alarms, nothing hidden", "unknown": "unknown, outside the catalogue",
    "channel_outside": "right channel, outside the catalogue",
    "both_named": "both named, two hidden", "one_named": "one at least named, two hidden",
    "shrink_error": "shrink, mean distance from the best", "shrink_near": "shrink within 0.1 of it",
    "coverage_amplitudes": "95 % intervals of sizes that hold",
    "coverage_parameters": "95 % intervals of parameters that hold",
}  # fmt: skip
BY_SIZE = ("top1", "top3", "location", "unknown", "channel_outside", "both_named", "shrink_error")
MISSING = "–"


def tables(scored: Mapping[str, Any]) -> "Group":
    """All tables of a score: measures, by size, by effect."""
    from rich.console import Group

    return Group(_overall(scored), _sizes(scored), _effects(scored))


def measure(of: Mapping[str, Any], *, interval: bool = True) -> str:
    """`0.93 (0.88–0.96), n 200`, or a dash."""
    if of["value"] is None:
        return MISSING
    text = f"{of['value']:.2f}"
    if interval and of["ci95"] is not None:
        text += f" ({of['ci95'][0]:.2f}–{of['ci95'][1]:.2f})"
    return f"{text}, n {of['n']}"


def _overall(scored: Mapping[str, Any]) -> "Table":
    table = _table(f"{scored['cases']} cases", "", "all sizes", "from 3 × detectable")
    for name, words in WORDS.items():
        later = MISSING if name == "false_alarm" else measure(scored["from_3"][name])
        table.add_row(words, measure(scored[name]), later)
    return table


def _sizes(scored: Mapping[str, Any]) -> "Table":
    bands = [band for band in scored["bands"] if any(band[name]["n"] for name in BY_SIZE)]
    heads = [
        f"{band['from']:g}–{band['to']:g} ×" if band["to"] else f"from {band['from']:g} ×"
        for band in bands
    ]
    table = _table("by size, in minimum detectable ones", "", *heads)
    for name in BY_SIZE:
        cells = [measure(band[name], interval=False) for band in bands]
        table.add_row(WORDS[name], *cells)
    return table


def _effects(scored: Mapping[str, Any]) -> "Table":
    table = _table(
        "by effect, alone in its rig", "hidden", "median size", "named", "location or channel",
        "said instead",
    )  # fmt: skip
    for id, row in scored["effects"].items():
        inside = row["kind"] == "one"
        table.add_row(
            id,
            f"{row['multiple']:.1f} ×",
            measure(row["top1" if inside else "unknown"], interval=False),
            measure(row["location" if inside else "channel"], interval=False),
            ", ".join(f"{said} {n}" for said, n in row["instead"].items()),
        )
    return table


def _table(title: str, *heads: str) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for head in heads:
        table.add_column(head)
    return table
