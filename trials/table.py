"""The score as sheets, and those as tables for a terminal."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Group

WORDS = {
    "top1": "cause, first named",
    "top1_alone": "  ties not counted as one",
    "top3": "cause, among the first three",
    "location": "location",
    "false_alarm": "false alarms, nothing hidden",
    "unknown": "unknown, outside the catalogue",
    "channel_outside": "right channel, outside the catalogue",
    "both_named": "both named, two hidden",
    "one_named": "one at least named, two hidden",
    "explained": "verdict explained, one or two hidden",
    "undetectable": "no size detectable, says the diagnosis",
    "shrink_error": "shrink, mean distance from the best",
    "shrink_near": "shrink within 0.1 of it",
    "coverage_amplitudes": "95 % intervals of sizes that hold",
    "coverage_parameters": "95 % intervals of parameters that hold",
    "cousin": "cousin, its kind named first",
    "cousin_location": "location, cousin",
    "harm_windowed": "causes that harm, windowed",
    "harm_free_run": "causes that harm, free run",
}
#: Asked of some trials only: rows of others do not mention them.
SOMETIMES = ("cousin", "cousin_location", "harm_windowed", "harm_free_run")
BY_SIZE = (
    "top1",
    "top3",
    "location",
    "unknown",
    "channel_outside",
    "both_named",
    "shrink_error",
    "cousin",
)
ALL_SIZES = ("false_alarm", "undetectable")
MISSING = "–"


@dataclass(frozen=True)
class Sheet:
    """A table without a form.

    Attributes:
        title: over it.
        heads: of the columns.
        rows: cells, as many in each as there are heads.
    """

    title: str
    heads: tuple[str, ...]
    rows: list[tuple[str, ...]]


def tables(scored: Mapping[str, Any]) -> "Group":
    """All sheets of a score, for a terminal."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Group
    from rich.table import Table

    drawn = []
    for sheet in sheets(scored):
        table = Table(title=sheet.title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
        for head in sheet.heads:
            table.add_column(head)
        for cells in sheet.rows:
            table.add_row(*cells)
        drawn.append(table)
    return Group(*drawn)


def sheets(scored: Mapping[str, Any]) -> list[Sheet]:
    """Measures, by size, by effect; how far stated probabilities hold, where any are stated."""
    return [_overall(scored), _sizes(scored), _effects(scored), *_stated(scored)]


def measure(of: Mapping[str, Any], *, interval: bool = True) -> str:
    """`0.93 (0.88–0.96), n 200`, or a dash."""
    if of["value"] is None:
        return MISSING
    text = f"{of['value']:.2f}"
    if interval and of["ci95"] is not None:
        text += f" ({of['ci95'][0]:.2f}–{of['ci95'][1]:.2f})"
    return f"{text}, n {of['n']}"


def _overall(scored: Mapping[str, Any]) -> Sheet:
    rows = []
    for name, words in WORDS.items():
        if name in SOMETIMES and not scored[name]["n"]:
            continue
        later = MISSING if name in ALL_SIZES else measure(scored["from_3"][name])
        rows.append((words, measure(scored[name]), later))
    return Sheet(f"{scored['cases']} cases", ("", "all sizes", "from 3 × detectable"), rows)


def _sizes(scored: Mapping[str, Any]) -> Sheet:
    bands = [band for band in scored["bands"] if any(band[name]["n"] for name in BY_SIZE)]
    heads = [
        f"{band['from']:g}–{band['to']:g} ×" if band["to"] else f"from {band['from']:g} ×"
        for band in bands
    ]
    rows = [
        (WORDS[name], *(measure(band[name], interval=False) for band in bands))
        for name in BY_SIZE
        if name not in SOMETIMES or scored[name]["n"]
    ]
    return Sheet("by size, in minimum detectable ones", ("", *heads), rows)


def _effects(scored: Mapping[str, Any]) -> Sheet:
    rows = []
    for id, row in scored["effects"].items():
        named = {"one": "top1", "cousin": "cousin"}.get(row["kind"], "unknown")
        place = "location" if row["kind"] == "one" else "channel"
        cells = (
            id,
            MISSING if row["multiple"] is None else f"{row['multiple']:.1f} ×",
            measure(row[named], interval=False),
            measure(row[place], interval=False),
            ", ".join(f"{said} {n}" for said, n in row["instead"].items()),
        )
        rows.append(cells)
    heads = ("hidden", "median size", "named", "location or channel", "said instead")
    return Sheet("by effect, alone in its rig", heads, rows)


def _stated(scored: Mapping[str, Any]) -> list[Sheet]:
    """Nothing for scores that keep no probabilities."""
    bins = [row for row in scored.get("reliability") or [] if row["n"]]
    if not bins:
        return []
    rows = []
    for row in bins:
        right = measure({"value": row["right"], "n": row["n"], "ci95": row["ci95"]})
        rows.append((f"{row['from']:g}–{row['to']:g}", f"{row['stated']:.3f}", right))
    heads = ("stated probability", "mean", "right")
    return [Sheet("first causes, as sure as is said", heads, rows)]
