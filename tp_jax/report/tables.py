"""The tables of the page, every cell as text."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from tp_jax.report import reading, verdict, words
from tp_jax.report.formatting import (
    MISSING,
    angles,
    duration,
    estimate,
    number,
    percent,
    percents,
    probability,
    unit,
    with_unit,
)


class Table(NamedTuple):
    """Heads and rows of text; numbers stand in the columns listed in `right`."""

    head: tuple[str, ...]
    rows: list[tuple[str, ...]]
    right: frozenset[int] = frozenset()


class Named(NamedTuple):
    """A cell with an id below its words."""

    words: str
    id: str


def gap(diagnosis: Mapping[str, Any]) -> Table | None:
    """The error on held-out data before and after."""
    found = reading.table(diagnosis, "gap")
    horizon, floor = reading.value(found, "horizon_s"), reading.floor(diagnosis)
    states = reading.states(diagnosis)
    kinds = {
        "windowed": "in windows" + ("" if horizon is None else f" of {number(horizon, 2)} s"),
        "free_run": "free run",
    }
    rows = []
    for key, name in kinds.items():
        sizes = [reading.value(found, state, key) for state in states]
        if any(size is not None for size in sizes):
            rows.append((name, *angles([*sizes, floor])))
    names = states if len(states) > 1 else ("error",)
    return made(("Error (rms) on held-out data", *names, "noise"), rows, 1, 2, 3)


def causes(diagnosis: Mapping[str, Any]) -> Table | None:
    """Accepted causes with their sizes."""
    rows = [
        (
            _effect(cause),
            probability(cause.get("probability")),
            percent(cause.get("shrink")),
            "; ".join(verdict.sizes(cause)) or MISSING,
        )
        for cause in reading.causes(diagnosis)
    ]
    return made(("Accepted cause", "probability", "shrink", "size"), rows, 1, 2)


def candidates(diagnosis: Mapping[str, Any]) -> Table | None:
    """All candidates that apply and of which something is known."""
    found = [row for row in reading.candidates(diagnosis) if reading.judged(row)]
    columns = {
        "Effect": [_effect(row) for row in found],
        "place": [reading.text(row, "location") or MISSING for row in found],
        "predicted shrink": [percent(row.get("predicted_shrink")) for row in found],
        "realised shrink": [percent(row.get("realised_shrink")) for row in found],
        "probability": [probability(row.get("probability")) for row in found],
        "z": [number(row.get("z"), 2) for row in found],
        "note": [reading.text(row, "note") or MISSING for row in found],
    }
    said = {name: cells for name, cells in columns.items() if any(c != MISSING for c in cells)}
    right = [i for i, name in enumerate(said) if name not in ("Effect", "place", "note")]
    return made(tuple(said), list(zip(*said.values(), strict=True)), *right)


def inapplicable(diagnosis: Mapping[str, Any]) -> Table | None:
    """Candidates that do not apply to this campaign, and why."""
    rows = [
        (_effect(row), reading.text(row, "note").removeprefix("Does not apply: ") or MISSING)
        for row in reading.inapplicable(diagnosis)
    ]
    return made(("Effect", "why it does not apply"), rows)


def first_rows(of: Table | None, most: int) -> tuple[Table | None, Table | None]:
    """A table's first rows, and the others in a table of their own; None where there are none.

    One row more than that is no reason to part them.
    """
    if of is None or len(of.rows) <= most + 1:
        return of, None
    return of._replace(rows=of.rows[:most]), of._replace(rows=of.rows[most:])


def places(diagnosis: Mapping[str, Any]) -> Table | None:
    """Where the gap lies, and when."""
    rows = [
        (
            words.capital(words.location(reading.text(place, "location"))),
            reading.text(place, "channel") or MISSING,
            percent(place.get("share")),
            verdict.when(reading.text(place, "when")) or MISSING,
        )
        for place in reading.rows(diagnosis, "where")
        if reading.text(place, "location")
    ]
    return made(("Place", "channel", "share", "when"), rows, 2)


def detectable(diagnosis: Mapping[str, Any]) -> Table | None:
    """The smallest size of each effect that this data would have shown."""
    rows = []
    for name, given in reading.table(diagnosis, "minimum_detectable").items():
        entry = reading.table(given)
        size = reading.value(entry, "value")
        text = "beyond its range" if size is None else with_unit(size, entry.get("unit"))
        rows.append((_named(name), text))
    return made(("Effect", "minimum detectable size"), rows, 1)


def parameters(diagnosis: Mapping[str, Any]) -> Table | None:
    """The fitted model's parameters, and how far each moved when the causes were added."""
    absorbed = reading.table(diagnosis, "absorbed")
    fitted = reading.table(diagnosis, "parameters")
    rows = []
    for name in dict.fromkeys([*fitted, *absorbed]):
        entry = reading.table(fitted, name)
        value, interval = estimate(entry.get("value"), entry.get("ci95"))
        if entry.get("identifiable") is False:
            interval = "not determined by this data"
        cells = [_named(name, words.parameter(name)), value, interval or MISSING]
        rows.append((*cells, unit(entry.get("unit")), *_moved(reading.table(absorbed, name))))
    head = ["Parameter", "value", "95 % interval", "unit", "moved by", "in standard errors"]
    if not any(cell not in ("", MISSING) for row in rows for cell in row[4:]):
        return made(tuple(head[:4]), [row[:4] for row in rows], 1)
    return made(tuple(head), rows, 1, 4, 5)


def provenance(diagnosis: Mapping[str, Any]) -> Table | None:
    """Where the numbers come from."""
    found = reading.table(diagnosis, "provenance")
    names = {"version": "tp-jax version", "seed": "seed", "wall_s": "computing time"}
    rows = []
    for key, name in (("campaign", "campaign"), ("model", "model"), ("schema", "schema")):
        rows.append((name, reading.text(diagnosis, key)))
    rows.append(("recorded", " to ".join(reading.recorded(diagnosis))))
    held_out = reading.texts(reading.table(diagnosis, "gap"), "held_out")
    rows.append(("held out, never fitted", ", ".join(held_out)))
    for key, entry in found.items():
        if isinstance(entry, str | int | float):
            text = duration(entry) if key == "wall_s" else str(entry)
            rows.append((names.get(key, key.replace("_", " ")), text))
    for file, digest in reading.table(found, "data_sha256").items():
        rows.append((f"SHA-256 of {file}", str(digest)))
    return made(("What", "is"), [row for row in rows if row[1]])


def scale_line(diagnosis: Mapping[str, Any]) -> str:
    """Which inertia of the column fixes the scale, as a sentence; empty where it is not known."""
    B1 = reading.value(diagnosis, "fits", "before", "parameters", "B1")
    if B1 is None:
        return ""
    if B1 == 1.0:
        return "No inertia B1 of the column was given, so torques and stiffness are per unit of B1."
    size = f"{number(B1, 7)} {unit('kg m^2')}"
    return f"The scale is fixed by the column's inertia as it was given: B1 = {size}."


def shrink_line(diagnosis: Mapping[str, Any]) -> str:
    """The shrink with its interval, as a sentence; empty where it is not known."""
    found = reading.table(diagnosis, "gap")
    shrink, interval = reading.value(found, "shrink"), percents(found.get("shrink_ci95"))
    if shrink is None:
        return ""
    interval = f" (95 % interval {interval})" if interval else ""
    if shrink < 0.0:
        return f"The gap grew by {percent(-shrink)} of what could be removed{interval}."
    return f"{percent(shrink)} of the removable gap is gone{interval}."


def floor_line(diagnosis: Mapping[str, Any]) -> str:
    """What the noise floor is made of, as a sentence; empty where it is noise alone."""
    parts = reading.table(diagnosis, "noise_floor_parts")
    said = []
    for channel, name in reading.CHANNELS.items():
        noise = reading.value(parts, "noise", channel)
        calibration = reading.value(parts, "calibration", channel)
        if noise is None or not calibration:
            continue
        first, second = angles([noise, calibration])
        said.append(f"{name} {first} of noise and {second} that its calibration may be off")
    return f"The floor is made of two parts: {'; '.join(said)}." if said else ""


def _moved(entry: Mapping[str, Any]) -> tuple[str, str]:
    if not entry:
        return MISSING, MISSING
    return number(entry.get("shift")), number(entry.get("in_standard_errors"), 2)


def _effect(row: Mapping[str, Any]) -> Any:
    return _named(reading.text(row, "effect"))


def _named(name: str, said: str | None = None) -> Any:
    """The words for an id, and the id; the id alone where there are no words."""
    said = words.clause(name) if said is None else said
    return Named(words.capital(said) or name, name if said else "")


def made(head: tuple[str, ...], rows: list[Any], *right: int) -> Table | None:
    """A table with numbers in the columns listed; None without rows."""
    return Table(head, rows, frozenset(right)) if rows else None
