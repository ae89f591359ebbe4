"""Survey of a data file of unknown make: its columns, and which of them may be what.

Everything here is a guess, written down by `tp-jax init` for the user to correct.
"""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from tp_jax.recordings import clocks, units
from tp_jax.recordings.cells import parse, split
from tp_jax.recordings.checks import WIDEST_PHI1
from tp_jax.recordings.clock_times import FORMS, has_zone, is_date_or_clock
from tp_jax.recordings.encoder import leaps, whole_numbers
from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.formats import empty_rows
from tp_jax.recordings.held import held
from tp_jax.recordings.joined import check_joined
from tp_jax.recordings.kinds import kind_of
from tp_jax.recordings.layout import layout_of
from tp_jax.recordings.lines import as_lines, read_bytes, without_separators
from tp_jax.recordings.readings import readings
from tp_jax.recordings.sources import NAMES, ColumnSource, FileFormat
from tp_jax.recordings.tables import as_numbers, is_dated, is_zoned, read_named

_WORDS = {
    "t": r"t|time\w*|zeit\w*|sec|seconds|sekunden|timestamp|zeitstempel|tijd|temps|czas|uhrzeit|"
    r"datum\w*|date\w*|micros\w*|millis\w*|ticks",
    "phi1": r"phi_?1|φ1|theta_?1|angle_?1|winkel_?1|ang1|enc(oder)?_?1|column|säule|disk_?1",
    "phi2": r"phi_?2|φ2|theta_?2|angle_?2|winkel_?2|ang2|enc(oder)?_?2|rider|ring|reiter|disk_?2",
    "drive": r"drive|antrieb|motor\w*|erreger\w*|excit\w*|force|f_?e",
}
"""Names that people give the columns, in the languages that turned up."""

_MEND = "leave it out, or export it as CSV"


@dataclass(frozen=True)
class Survey:
    """Result of the survey of a file.

    Attributes:
        delimiter, decimal: of a text; None for files of other kinds.
        header: whether the columns have names.
        sources: name in the recording -> where it seems to be, with its unit.
        why: name in the recording -> what speaks for it, in words.
        t, phi1: (n,) as the sources give them [s], [rad].
        held: whether readings are held.
        notes: what reading by the sources does to the rows, a sentence each, without its end.
        phi2: (n,) the second angle [rad]; None where none was found.
    """

    delimiter: str | None
    decimal: str | None
    header: bool
    sources: dict[str, ColumnSource]
    why: dict[str, str]
    t: np.ndarray
    phi1: np.ndarray
    held: bool = False
    notes: tuple[str, ...] = field(default=())
    phi2: np.ndarray | None = None


def survey(file: Path) -> Survey:
    """Looks at a data file.

    Raises:
        CampaignError: it cannot be read, or has no two columns of numbers.
    """
    raw = read_bytes(file)
    kind = kind_of(file, raw[:4096])
    if kind is not None:
        table = read_named(file, kind, None)
        names, told = list(table), [units.parted(name)[1] for name in table]
        columns = {}
        for i, name in enumerate(names):
            try:
                columns[i] = as_numbers(file, "t", table[name])
            except CampaignError:  # texts
                continue
        dates = {i for i, name in enumerate(names) if is_dated(table[name])}
        zoned = {i for i, name in enumerate(names) if is_zoned(table[name])}
        layout, notes = None, ()
    else:
        lines, left_out = without_separators(as_lines(file, raw))
        layout = layout_of(lines, FileFormat())
        if layout.first >= len(lines.text):
            raise CampaignError(file, "there are no rows of numbers in it", _MEND)
        names = layout.header
        below = layout.below
        width = len(split(lines.text[layout.first], layout.delimiter))
        told = [
            (units.parted(names[i])[1] if i < len(names) else "")
            or (below[i].strip("[]() ") if i < len(below) else "")
            for i in range(width)
        ]
        columns, dates, zoned = {}, set(), set()
        notes = empty_rows(file, left_out, lines.numbers[layout.first])
        at = next((i for i in layout.numeric if _is_time(names, i)), None)
        check_joined(lines, layout, next(iter(layout.numeric), None) if at is None else at)
        for i in layout.numeric:
            first = split(lines.text[layout.first], layout.delimiter)[i]
            if is_date_or_clock(first):
                dates.add(i)
            if has_zone(first):
                zoned.add(i)
            columns[i] = parse(
                lines, layout.first, {"t": i}, layout.delimiter, layout.decimal, layout.like
            )["t"]
    if len(columns) < 2:
        raise CampaignError(file, "there are no two columns of numbers in it", _MEND)
    which = _which(names, columns)
    if "t" not in which:
        raise CampaignError(file, "no column in it can be read as a time", FORMS)
    sources, why, unread = {}, {}, []
    for name, i in which.items():
        column = names[i] if i < len(names) and names.count(names[i]) == 1 else i
        said = told[i] if i < len(told) else ""
        unit = units.named(said, units.of(name)) if said else None
        dated = i in dates, i in zoned
        sources[name], why[name] = _source(name, column, unit, columns, which, dated)
        if said and unit is None and name != "drive":
            guess = sources[name].unit or ("counts" if sources[name].counts else "rad")
            why[name] += f"; the file says {said!r}"
            unread.append(
                f"{file.name}: {name} is in {said!r}, says the file, which is no unit of "
                f"{'a time' if name == 't' else 'an angle'} that is known here; "
                f"{guess} is a guess, so correct it in campaign.toml"
            )
    angles = {name: columns[i] for name, i in which.items() if name in ("phi1", "phi2")}
    holds = any(np.isfinite(x).all() and held(x) is not None for x in angles.values())
    read = readings(
        file,
        sources,
        {"t": columns[which["t"]], **angles},
        dated=which["t"] in dates,
        zoned=which["t"] in zoned,
        held=holds,
    )
    return Survey(
        None if layout is None else layout.delimiter or " ",
        None if layout is None else layout.decimal,
        bool(names),
        sources,
        why,
        read.values["t"],
        read.values["phi1"],
        holds,
        (*notes, *unread, *read.notes),
        read.values.get("phi2"),
    )


def _is_time(names: list[str], i: int) -> bool:
    bare = units.parted(names[i])[0].strip('"').lower() if i < len(names) else ""
    return re.fullmatch(_WORDS["t"], bare) is not None


def _which(names: list[str], columns: dict[int, np.ndarray]) -> dict[str, int]:
    """Name in the recording -> index of the column that seems to hold it."""
    found: dict[str, int] = {}
    for name, words in _WORDS.items():
        for i in columns:
            bare = units.parted(names[i])[0].strip('"').lower() if i < len(names) else ""
            if i not in found.values() and re.fullmatch(words, bare):
                found[name] = i
                break
    rising = [i for i, x in columns.items() if x.size > 1 and np.all(np.diff(x) > 0.0)]
    if "t" not in found:
        left = [i for i in rising if i not in found.values()]
        left = left or [i for i, x in columns.items() if i not in found.values() and _runs_on(x)]
        left = left or [i for i in columns if i not in found.values()]
        if left:
            found["t"] = left[0]
    for name in ("phi1", "phi2"):
        # a column that only rises is a number of rows
        left = [i for i in columns if i not in found.values() and i not in rising]
        if name not in found and left:
            found[name] = left[0]
    if "phi1" not in found:
        found["phi1"] = next(i for i in columns if i != found.get("t"))
    return {name: found[name] for name in NAMES if name in found}


def _runs_on(x: np.ndarray) -> bool:
    """True if a column is like a clock that falls or stands still now and then."""
    steps = np.diff(x)
    falls, usual = np.mean(steps < 0.0), clocks.usual_step(x)
    return bool(x.size > 1 and falls < 0.01 and np.mean(steps[steps > 0.0] < 2.0 * usual) > 0.9)


def _source(
    name: str,
    column: str | int,
    unit: str | None,
    columns: dict[int, np.ndarray],
    which: dict[str, int],
    dated: tuple[bool, bool],
) -> tuple[ColumnSource, str]:
    cells = columns[which[name]]
    source = ColumnSource(column, unit=unit)
    if name == "drive":
        return source, ""
    if name == "t":
        return _clock(source, cells, *dated)
    if unit is not None:
        why = "the file says so"
    else:
        width = float(np.ptp(cells))
        if whole_numbers(cells):
            counts = 2.0 ** max(8, int(np.ceil(np.log2(width + 1.0))))
            source = replace(source, counts=counts)
            why = f"whole numbers that span {width:g}; correct the counts of a whole turn"
        elif width > WIDEST_PHI1:
            source, why = replace(source, unit="deg"), f"spans {width:.4g}"
        else:
            why = f"spans {width:.4g}"
    leap = leaps(columns[which["t"]], cells)
    if leap is not None and leap.period is not None:
        if source.counts is not None:
            source = replace(source, counts=leap.period)
        source = replace(source, wrap=leap.period)
        why += f", starts anew after {leap.period:g}"
    return source, why


def _clock(
    source: ColumnSource, cells: np.ndarray, is_date: bool, zoned: bool
) -> tuple[ColumnSource, str]:
    """Unit of the times, and what keeps them from rising."""
    step = clocks.usual_step(cells)
    if source.unit is not None:
        why = "the file says so"
    elif is_date:
        why = "dates or clock times, in seconds from the first"
    else:
        source = replace(source, unit=clocks.unit_of_step(step))
        why = f"steps of {step:.4g}"
    period = clocks.period_of(cells)
    if period is not None:
        return replace(source, wrap=period), f"{why}, starts anew after {period:.10g}"
    t = source.apply("t", cells)
    fall = clocks.fall_of(t, is_date, None, zoned) if np.isfinite(t).all() else None
    if fall is not None and fall.cause == "hour":
        source = replace(source, summer_time=True)
        why += ", an hour of summer time " + ("begins" if t[fall.at] > t[fall.at - 1] else "ends")
    return source, why
