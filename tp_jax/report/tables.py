"""The tables of the page, every cell as text."""

from typing import Any, NamedTuple

from tp_jax.report import verdict, words
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
from tp_jax.report.inertia import given, inertia
from tp_jax.results.diagnosis import CHANNELS, DiagnosisRecord, Shift, Size


class Table(NamedTuple):
    """Heads and rows of text; numbers stand in the columns listed in `right`."""

    head: tuple[str, ...]
    rows: list[tuple[str, ...]]
    right: frozenset[int] = frozenset()


class Named(NamedTuple):
    """A cell with an id below its words."""

    words: str
    id: str


def gap(diagnosis: DiagnosisRecord) -> Table | None:
    """The error on held-out data before and after."""
    horizon, states = diagnosis.gap.horizon_s, diagnosis.states
    found = [getattr(diagnosis.gap, state) for state in states]
    kinds = {
        "in windows" + ("" if horizon is None else f" of {number(horizon, 2)} s"): "windowed",
        "free run": "free_run",
    }
    rows = []
    for name, kind in kinds.items():
        sizes = [getattr(errors, kind) for errors in found]
        if any(size is not None for size in sizes):
            rows.append((name, *angles([*sizes, diagnosis.floor])))
    names = states if len(states) > 1 else ("error",)
    return made(("Error (rms) on held-out data", *names, "noise"), rows, 1, 2, 3)


def causes(diagnosis: DiagnosisRecord) -> Table | None:
    """Accepted causes with their sizes."""
    rows = [
        (
            _named(cause.effect),
            probability(cause.probability),
            percent(cause.shrink),
            "; ".join(verdict.sizes(cause)) or MISSING,
        )
        for cause in diagnosis.accepted
    ]
    return made(("Accepted cause", "probability", "shrink", "size"), rows, 1, 2)


def candidates(diagnosis: DiagnosisRecord) -> Table | None:
    """All candidates that apply and of which something is known."""
    found = [row for row in diagnosis.applicable if row.judged]
    columns = {
        "Effect": [_named(row.effect) for row in found],
        "place": [row.location or MISSING for row in found],
        "predicted shrink": [percent(row.predicted_shrink) for row in found],
        "realised shrink": [percent(row.realised_shrink) for row in found],
        verdict.chance_of_candidates(diagnosis): [probability(row.probability) for row in found],
        "note": [row.note or MISSING for row in found],
    }
    said = {name: cells for name, cells in columns.items() if any(c != MISSING for c in cells)}
    right = [i for i, name in enumerate(said) if name not in ("Effect", "place", "note")]
    return made(tuple(said), list(zip(*said.values(), strict=True)), *right)


def inapplicable(diagnosis: DiagnosisRecord) -> Table | None:
    """Candidates that do not apply to this campaign, and why."""
    rows = [
        (_named(row.effect), (row.note or "").removeprefix("Does not apply: ") or MISSING)
        for row in diagnosis.candidates
        if row.applicable is False
    ]
    return made(("Effect", "why it does not apply"), rows)


def first_rows(of: Table | None, most: int) -> tuple[Table | None, Table | None]:
    """A table's first rows, and the others in a table of their own; None where there are none.

    One row more than that is no reason to part them.
    """
    if of is None or len(of.rows) <= most + 1:
        return of, None
    return of._replace(rows=of.rows[:most]), of._replace(rows=of.rows[most:])


def places(diagnosis: DiagnosisRecord) -> Table | None:
    """Table of where the gap lies, and when."""
    rows = [
        (
            words.capital(words.location(place.location)),
            place.channel or MISSING,
            percent(place.share),
            verdict.when(place.when or "") or MISSING,
        )
        for place in diagnosis.where
    ]
    return made(("Place", "channel", "share", "when"), rows, 2)


def detectable(diagnosis: DiagnosisRecord) -> Table | None:
    """The smallest size of each effect that this data would have shown."""
    rows = [
        (
            _named(name),
            "beyond its range" if size.value is None else with_unit(size.value, size.unit),
        )
        for name, size in diagnosis.minimum_detectable.items()
    ]
    return made(("Effect", "minimum detectable size"), rows, 1)


def parameters(diagnosis: DiagnosisRecord) -> Table | None:
    """The fitted model's parameters, and how far each moved when the causes were added."""
    rows = []
    for name in dict.fromkeys([*diagnosis.parameters, *diagnosis.absorbed]):
        size = diagnosis.parameters.get(name, Size())
        shift = diagnosis.absorbed.get(name, Shift())
        value, interval = estimate(size.value, size.ci95)
        if size.identifiable is False:
            interval = "not determined by this data"
        cells = [_named(name, words.parameter(name)), value, interval or MISSING, unit(size.unit)]
        rows.append((*cells, number(shift.shift), number(shift.in_standard_errors, 2)))
    head = ["Parameter", "value", "95 % interval", "unit", "moved by", "in standard errors"]
    if not any(cell not in ("", MISSING) for row in rows for cell in row[4:]):
        return made(tuple(head[:4]), [row[:4] for row in rows], 1)
    return made(tuple(head), rows, 1, 4, 5)


def provenance(diagnosis: DiagnosisRecord) -> Table | None:
    """Origin of the numbers."""
    found = diagnosis.provenance
    rows = [
        ("campaign", diagnosis.campaign),
        ("model", diagnosis.model),
        ("schema", diagnosis.schema),
        ("recorded", " to ".join(diagnosis.recorded)),
        ("held out, never fitted", ", ".join(verdict.held_out(diagnosis))),
        ("tp-jax version", found.version),
        ("seed", "" if found.seed is None else str(found.seed)),
        ("computing time", "" if found.wall_s is None else duration(found.wall_s)),
        *((f"SHA-256 of {file}", digest) for file, digest in found.data_sha256.items()),
    ]
    return made(("What", "is"), [row for row in rows if row[1]])


def scale_line(diagnosis: DiagnosisRecord) -> str:
    """Says which inertia of the column fixes the scale; empty where it is not known."""
    B1 = inertia(diagnosis)
    if B1 is None:
        return ""
    if not given(B1):
        return "No inertia B1 of the column was given, so torques and stiffness are per unit of B1."
    size = f"{number(B1, 7)} {unit('kg m^2')}"
    return f"The scale is fixed by the column's inertia as it was given: B1 = {size}."


def shrink_line(diagnosis: DiagnosisRecord) -> str:
    """The shrink with its interval, as a sentence; empty where it is not known."""
    shrink = diagnosis.gap.shrink
    if shrink is None:
        return ""
    interval = percents(diagnosis.gap.shrink_ci95, negated=shrink < 0.0)
    interval = f" (95 % interval {interval})" if interval else ""
    if shrink < 0.0:
        return f"The gap grew by {percent(-shrink)} of what could be removed{interval}."
    return f"{percent(shrink)} of the removable gap is gone{interval}."


def floor_line(diagnosis: DiagnosisRecord) -> str:
    """Says what the noise floor is made of; empty where it is noise alone."""
    parts = diagnosis.noise_floor_parts
    said = []
    for channel, name in CHANNELS.items():
        noise, calibration = parts.noise.get(channel), parts.calibration.get(channel)
        if noise is None or not calibration:
            continue
        first, second = angles([noise, calibration])
        said.append(f"{name} {first} of noise and {second} that its calibration may be off")
    return f"The floor is made of two parts: {'; '.join(said)}." if said else ""


def _named(name: str, said: str | None = None) -> Any:
    """The words for an id, and the id; the id alone where there are no words."""
    said = words.clause(name) if said is None else said
    return Named(words.capital(said) or name, name if said else "")


def made(head: tuple[str, ...], rows: list[Any], *right: int) -> Table | None:
    """A table with numbers in the columns listed; None without rows."""
    return Table(head, rows, frozenset(right)) if rows else None
