"""The page of a fleet: rigs by cause, and a table that sorts and filters itself.

Its one script stands in the page, whose policy names it by its hash and allows nothing else.
"""

import base64
import hashlib
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from tp_jax._version import __version__
from tp_jax.report import words
from tp_jax.report.fleet.rows import FAILED, VERDICTS, by_cause, counts
from tp_jax.report.fleet.shared import KIND_HEAD, OWN_HEAD, told
from tp_jax.report.fleet.text import NAMES
from tp_jax.report.formatting import (
    MISSING,
    angles,
    estimate,
    number,
    percent,
    percents,
    probability,
    unit,
)
from tp_jax.report.html import environment

FOLDER = Path(__file__).parent


class Cell(NamedTuple):
    """Content of a cell, and by what it is sorted.

    Attributes:
        text: shown. by: a number or a text; None comes last.
        small: below it, in small. id: of an effect, shown as code.
    """

    text: str
    by: float | str | None
    small: str = ""
    id: str = ""


class Column(NamedTuple):
    """A column's head; kind: "text" or "number"."""

    name: str
    kind: str


COLUMNS = (
    Column("Rig", "text"),
    Column("Verdict", "text"),
    Column("Cause", "text"),
    Column("Place", "text"),
    Column("Size", "number"),
    Column("Probability", "number"),
    Column("Shrink", "number"),
    Column("Error before", "number"),
    Column("Error after", "number"),
)


class Row(NamedTuple):
    """A rig in the table; verdict, cause and place are what the filters compare."""

    cells: list[Cell]
    report: str
    verdict: str
    cause: str
    place: str
    error: str
    notices: str


def render(
    rows: Sequence[Mapping[str, Any]],
    name: str,
    *,
    day: date | None = None,
    shared: Mapping[str, Any] | None = None,
) -> str:
    """The page as text.

    Args:
        rows: as `rows.row` and `rows.failed` make them, in the order to be shown first.
        name: of the fleet.
        day: on which it was diagnosed.
        shared: what the rigs share, as fleet.json has it; None where nobody asked.
    """
    script = (FOLDER / "fleet.js").read_text(encoding="utf-8")
    hashed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    known = counts(rows)
    shown = [_row(each) for each in rows]
    return (
        environment()
        .get_template("fleet/fleet.html.j2")
        .render(
            name=name,
            heading=_heading(len(rows), known),
            day="" if day is None else day.isoformat(),
            version=__version__,
            verdicts=[(NAMES[v], known[v]) for v in VERDICTS if known[v]],
            groups=_groups(rows),
            shared=None if shared is None else told(shared),
            heads=(KIND_HEAD, OWN_HEAD),
            columns=COLUMNS,
            rows=shown,
            filters=_filters(shown),
            script=script,
            script_hash=hashed,
        )
    )


def _heading(total: int, known: Mapping[str, int]) -> str:
    rigs = "rig" if total == 1 else "rigs"
    return f"{total} {rigs}, {known['explained']} with a gap that is explained"


def _filters(rows: Sequence[Row]) -> list[tuple[str, str, list[str]]]:
    """Name, label and choices of each filter that has something to choose."""
    found = []
    for key, label in (("verdict", "Verdict"), ("cause", "Cause"), ("place", "Place")):
        choices = sorted({getattr(row, key) for row in rows} - {""})
        if len(choices) > 1:
            found.append((key, label, choices))
    return found


def _groups(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, int, str, str, str]]:
    """A line for each cause: what it does, its id, rigs, places, sizes, shrinks."""
    found = []
    for cause, mine in by_cause(rows).items():
        places = sorted({words.location(one["location"]) for one in mine if one["location"]})
        sizes = _range([one["value"] for one in mine], lambda values: [number(x) for x in values])
        parameters = {(one["parameter"], one["unit"]) for one in mine if one["parameter"]}
        if len(parameters) > 1:
            sizes = MISSING  # torques of some rigs are per unit of their inertia
        elif sizes != MISSING:
            ((parameter, of),) = parameters
            sizes = f"{parameter} {sizes} {unit(of)}".rstrip()
        shrinks = _range([one["shrink"] for one in mine], lambda values: list(map(percent, values)))
        said = words.capital(words.effect(cause))
        found.append((said, cause, len(mine), ", ".join(places) or MISSING, sizes, shrinks))
    return found


def _range(values: Sequence[float | None], told) -> str:
    """`0.31, 0.22 to 0.45`: the median, then the ends where they differ."""
    known = sorted(x for x in values if x is not None)
    if not known:
        return MISSING
    middle, low, high = told([median(known), known[0], known[-1]])
    return middle if low == high else f"{middle}, {low} to {high}"


def _row(one: Mapping[str, Any]) -> Row:
    size, interval = estimate(one["value"], _pair(one["value_low"], one["value_high"]))
    of = unit(one["unit"])
    size = MISSING if one["value"] is None else f"{one['parameter']} {size} {of}".rstrip()
    before, after = angles([one["gap_before"], one["gap_after"]])
    cause = one["cause"] or ""
    others = "; ".join(
        filter(
            None,
            [
                f"also {one['other_causes']}" if one["other_causes"] else "",
                f"not told from {one['confused_with']}" if one["confused_with"] else "",
            ],
        )
    )
    place = words.capital(words.location(one["location"])) if one["location"] else ""
    does = words.capital(words.effect(cause)) if cause else MISSING
    known = one["probability"]
    cells = [
        Cell(one["rig"], one["rig"], _campaign(one)),
        Cell(words.capital(NAMES[one["verdict"]]), VERDICTS.index(one["verdict"])),
        Cell(does, cause or None, others, cause),
        Cell(place or MISSING, place or None),
        Cell(size, one["value"], interval),
        Cell(MISSING if known is None else probability(known), known),
        Cell(
            percent(one["shrink"]),
            one["shrink"],
            percents(_pair(one["shrink_low"], one["shrink_high"])),
        ),
        Cell(before, one["gap_before"]),
        Cell(after, one["gap_after"]),
    ]
    return Row(
        cells,
        one["report"] or "",
        NAMES[one["verdict"]],
        cause,
        place,
        one["error"] or "" if one["verdict"] == FAILED else "",
        one["notices"] or "",
    )


def _campaign(one: Mapping[str, Any]) -> str:
    """The campaign's own name, where it is another than the rig's in the fleet."""
    return one["campaign"] if one["campaign"] and one["campaign"] != one["rig"] else ""


def _pair(low: float | None, high: float | None) -> list[float] | None:
    return None if low is None or high is None else [low, high]
