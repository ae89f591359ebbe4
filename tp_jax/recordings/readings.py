"""Cells of a file to the columns of a recording: units, turns, clocks, rows that say nothing new.

A note reports what was done to the rows in addition to units: nothing is left out in silence.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tp_jax.recordings import clocks
from tp_jax.recordings.held import new_only
from tp_jax.recordings.rounding import made_even
from tp_jax.recordings.short import short_fields
from tp_jax.recordings.sources import ColumnSource

FAR_BEGIN = 1e6
"""Durations of a run before it from which a clock's zero is no time that matters to it; times of
a day and of a board since it was switched on stay far below."""


@dataclass(frozen=True)
class Readings:
    """Columns in seconds and radians.

    Attributes:
        values: name -> (n,) values.
        rows: (n,) indices of the rows of cells that they come from.
        notes: what was done to them, a sentence each, without its end.
    """

    __repr__ = short_fields

    values: dict[str, np.ndarray]
    rows: np.ndarray
    notes: tuple[str, ...]


# Cells may hold any number: what a step of 1e308 is called, infinite or not, decides nothing here.
@np.errstate(over="ignore", invalid="ignore")
def readings(
    file: Path,
    sources: Mapping[str, ColumnSource],
    cells: Mapping[str, np.ndarray],
    *,
    dated: bool = False,
    zoned: bool = False,
    held: bool = False,
) -> Readings:
    """Reads the cells of a file.

    A column that another is counted from must be among them.

    Args:
        file: the file, for notes.
        sources: name in the recording -> where it comes from.
        cells: name -> (n,) cells.
        dated: times were written as dates or clock times.
        zoned: dates that tell their offset from UTC, see `Columns`.
        held: readings are held, see `FileFormat`.
    """
    values = {name: sources[name].apply(name, column) for name, column in cells.items()}
    notes = []
    rows = np.arange(next(iter(values.values())).size)
    if "t" in values:
        values["t"], notes = _times(sources["t"], cells, values["t"], dated, zoned)
        angles = {name: column for name, column in values.items() if name != "t"}
        usable = bool(np.all(np.diff(values["t"]) > 0.0)) and all(
            np.isfinite(each).all() for each in values.values()
        )
        once = _once(values, angles) if held and angles and not usable else None
        if once is not None:
            values, kept = once
            notes.append(
                f"{kept.size} of {rows.size} rows were kept, the first of each time and readings"
            )
            return _readings(file, sources, values, kept, notes)
        found = new_only(values["t"], angles) if held and angles and usable else None
        if found is not None:
            values["t"], angles, rows, which = found
            values |= angles
            slowest = max(which.values(), key=lambda each: each.rows)
            rate = 1.0 / float(np.median(np.diff(values["t"])))
            notes.append(
                f"readings come {rate:.4g} times a second, and one of {slowest.rows:.4g} rows was "
                f"kept, {rows.size} of {next(iter(cells.values())).size}"
            )
    return _readings(file, sources, values, rows, notes)


def _readings(
    file: Path,
    sources: Mapping[str, ColumnSource],
    values: dict[str, np.ndarray],
    rows: np.ndarray,
    notes: list[str],
) -> Readings:
    """Takes off what a column is counted from."""
    absolute = dict(values)
    for name in values:
        minus = sources[name].minus
        if minus is not None:
            values[name] = absolute[name] - absolute[minus]
    return Readings(values, rows, tuple(f"{file}: {note}" for note in notes))


def _once(
    values: Mapping[str, np.ndarray], angles: Mapping[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], np.ndarray] | None:
    """The rows without those that repeat time and readings of the one before; None: there are none.

    Times must rise then.
    """
    t = values["t"]
    new = np.concatenate([[True], ~(repeated(angles) & (t[1:] == t[:-1]))])
    rows = np.flatnonzero(new)
    if rows.size == t.size or not np.all(np.diff(t[rows]) > 0.0):
        return None
    return {name: column[rows] for name, column in values.items()}, rows


def _times(
    source: ColumnSource,
    cells: Mapping[str, np.ndarray],
    t: np.ndarray,
    dated: bool,
    zoned: bool,
) -> tuple[np.ndarray, list[str]]:
    """Times that run on, and what was done to them."""
    notes = []
    if not np.isfinite(t).all():
        return t, notes
    period = source.period("t", cells["t"])
    if period is not None:
        at = clocks.counted_on(cells["t"], period)[1]
        if at.size:
            notes.append(
                f"the clock starts anew {_times_over(at.size)} after {period:.10g}, and was "
                "counted on (unwrapped) from the first row"
            )
    if source.wrap is not None:  # a board's time since it was switched on is that of no run
        t = t - (t[0] - source.offset)
    if source.summer_time and not zoned:
        t, at = clocks.without_hours(t, dated)
        if at.size:
            notes.append("an hour of summer time was taken off the times")
    t, note = from_first_row(t)
    notes += note
    even, quantum = even_times(t, cells)
    if quantum is not None:
        even = even - even[0] if dated else even  # dates count from the first
        step = float(np.median(np.diff(even)))
        notes.append(
            f"times are rounded to {quantum:.3g} s, and the rows, which come evenly, were put "
            f"{step:.6g} s apart, {1.0 / step:.6g} a second"
        )
    return even, notes


def from_first_row(t: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Finite times, counted from the first where their clock began long before, and a note of it.

    Times since 1970 would hide what a clock does in a run of seconds.
    """
    if not t.size or not 0.0 < FAR_BEGIN * float(np.ptp(t)) < abs(t[0]):
        return t, []
    # The difference has digits that the times had not; without them 0.004 is 0.004 again, and a
    # quantum to which the times were rounded is found.
    digits = int(np.floor(-np.log10(2.0 * np.spacing(np.abs(t).max()))))
    note = (
        f"times begin at {t[0]:.10g} s, as on a clock that counts from a date, and were counted "
        "from the first row"
    )
    return np.round(t - t[0], digits), [note]


def even_times(
    t: np.ndarray, readings: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, float | None]:
    """Times, even where they were rounded and rows came evenly, and what they were rounded to.

    Args:
        t: (n,) finite times [s].
        readings: name -> (n,) readings of the same rows; "t" is not looked at.
    """
    if t.size < 2:
        return t, None
    found = made_even(t, repeated(readings))
    return (t, None) if found is None else (found.t, found.quantum)


def repeated(readings: Mapping[str, np.ndarray]) -> np.ndarray:
    """(n - 1,) whether a row has the readings of the one before; "t" is not looked at."""
    same = [column[1:] == column[:-1] for name, column in readings.items() if name != "t"]
    n = next(iter(readings.values())).size - 1
    return np.logical_and.reduce(same) if same else np.zeros(n, dtype=bool)


def _times_over(n: int) -> str:
    return "once" if n == 1 else f"{n} times"
