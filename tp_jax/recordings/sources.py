"""Source of a column of a recording, and how a reading becomes seconds or radians."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tp_jax.recordings import clocks, units
from tp_jax.recordings.faults import listed
from tp_jax.recordings.short import short_fields

NAMES = ("t", "phi1", "phi2", "drive")
"""The columns a recording can have."""

REQUIRED = ("t", "phi1")


@dataclass(frozen=True)
class ColumnSource:
    """Source of a column: `value = scale * cell * (the unit's factor) + offset`.

    Attributes:
        column: its name in the file's header, or its 0-based index.
        scale: unit of the recording per unit of the file.
        offset: in the recording's unit.
        unit: the file's, a name of `units`; None: seconds or radians.
        counts: of an encoder in a whole turn, where the cells are counts.
        wrap: after how many of the cell's own units the reading starts anew; None: it never does;
            True: after a whole turn, and a clock after what its fall tells.
        summer_time: local times, without the hour by which they fall back or spring ahead.
        minus: name of the column that is to be taken off, in the recording's unit.
    """

    column: str | int
    scale: float = 1.0
    offset: float = 0.0
    unit: str | None = None
    counts: float | None = None
    wrap: float | bool | None = None
    minus: str | None = None
    summer_time: bool = False

    __repr__ = short_fields

    def factor(self, name: str) -> float:
        """Seconds or radians per unit of the cell, for the column of this name."""
        if self.counts is not None:
            return self.scale * 2.0 * math.pi / self.counts
        return self.scale * (1.0 if self.unit is None else units.of(name)[self.unit])

    def period(self, name: str, cells: np.ndarray) -> float | None:
        """Finds after how many of the cell's units the reading starts anew; None: it does not."""
        if self.wrap is not True:
            return self.wrap or None
        if name == "t":
            return clocks.period_of(cells)
        return abs(2.0 * math.pi / self.factor(name))

    def apply(self, name: str, cells: np.ndarray) -> np.ndarray:
        """(n,) values of the column of this name, `minus` and hours not yet taken off."""
        period = self.period(name, cells)
        if period is not None:
            cells = clocks.counted_on(cells, period)[0] if name == "t" else unwrapped(cells, period)
        factor = self.factor(name)
        # bit for bit what was written, where there is nothing to be done
        return cells if (factor, self.offset) == (1.0, 0.0) else cells * factor + self.offset

    def changed(self, given: Mapping[str, Any]) -> "ColumnSource":
        """A copy with other settings; a unit and counts of an encoder take each other's place."""
        if "unit" in given:
            return replace(self, **{"counts": None, **given})
        return replace(self, **({"unit": None} if "counts" in given else {}), **given)

    def toml(self) -> str:
        """Returns it as it is written in a campaign.toml."""
        own = {name: value for name, value in vars(self).items() if value != _PLAIN.get(name)}
        return toml_table(own)


_PLAIN = {
    "scale": 1.0,
    "offset": 0.0,
    "unit": None,
    "counts": None,
    "wrap": None,
    "minus": None,
    "summer_time": False,
}


def toml_table(settings: Mapping[str, Any]) -> str:
    """Settings in braces, `{ unit = "ms", wrap = true }`; tables may be in it."""
    return "{ " + ", ".join(f"{name} = {_toml(value)}" for name, value in settings.items()) + " }"


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return toml_table(value)
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() else f"{value:.10g}"
    return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class FileFormat:
    """Layout of a file; what is None is found out from the file.

    Attributes:
        delimiter: one character; " " stands for any white space.
        decimal: "." or ",".
        skip_lines: number of header lines, blank ones not counted; the line with the columns'
            names may be counted or not.
        columns: name in the recording -> where it is in the file; empty: by the file's header,
            or in the order t, phi1, phi2.
        sheet: of a workbook; None: the first.
        held: readings are held, and of rows that repeat one only the first is to be kept.
        changes: of one file beside all others, name in the recording -> its own settings.
    """

    delimiter: str | None = None
    decimal: str | None = None
    skip_lines: int | None = None
    columns: Mapping[str, ColumnSource] = field(default_factory=dict)
    sheet: str | None = None
    held: bool = False
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def unwrapped(cells: np.ndarray, period: float) -> np.ndarray:
    """Readings that start anew after `period`, counted on; those that are not finite stay.

    Whole turns are taken off so that the middle of the motion is the one next to zero: otherwise
    runs that begin a little above zero and a little below would be a turn apart.
    """
    finite = np.isfinite(cells)
    if not finite.any():
        return cells
    counted = cells.copy()
    counted[finite] = np.unwrap(cells[finite], period=period)
    return counted - period * np.round(np.median(counted[finite]) / period)


def from_header(
    header: Sequence[str],
    below: Sequence[str],
    changes: Mapping[str, Mapping[str, Any]],
    wanted: Sequence[str],
    fault: Callable[[str, str], Exception],
) -> dict[str, ColumnSource]:
    """Columns by the names in a header: "phi1", or "phi1 [deg]", or its unit in the line below.

    Args:
        header: cells of the line with the names.
        below: those of the line below it, which may be units; empty where there is none.
        changes: as of `FileFormat`; a column whose unit is given there may have any in the file.
        wanted: names of the columns to be read; units of others do not matter.
        fault: makes an exception from what is wrong and how to mend it.

    Returns:
        Those of `NAMES` that are there, and those of `REQUIRED` in any case.

    Raises:
        Exception: what `fault` makes, where a column's unit is not known.
    """
    found = {}
    read = {*wanted, *(given.get("minus") for given in changes.values())}
    under = below if any(_is_unit(cell) for cell in below) else ()
    for name in NAMES:
        i = _position(name, header)
        if i is None:
            continue
        table, cell = units.of(name), header[i]
        text = units.parted(cell)[1] or (_unit_text(under[i]) if i < len(under) else "")
        unit = units.named(text, table)
        given = changes.get(name, {})
        # the drive is known up to a gain, so that it may be in volts or anything
        known = unit is not None or text in ("", "-") or not table or {"unit", "counts"} & {*given}
        if not known and name in read:
            told = cell if units.parted(cell)[1] else under[i]
            raise fault(
                f'the unit of {name} is not known in the cell "{told}"',
                f"write one of {listed(table, 12)} there, or give the unit or the counts of a "
                f"turn under [format.columns] in campaign.toml, as in {name} = {{ unit = "
                f'"{"ms" if name == "t" else "deg"}" }}',
            )
        plain = unit is None or table[unit] == 1.0
        found[name] = ColumnSource(cell, unit=None if plain else unit)
    for name in REQUIRED:
        found.setdefault(name, ColumnSource(name))  # a fault of whoever looks for it
    return found


def _position(name: str, header: Sequence[str]) -> int | None:
    """Index of a name in a header; before the name alone come neither units nor remarks."""
    parted = [units.parted(cell) for cell in header]
    ways = (
        [cell == name for cell in header],
        [bare == name and units.named(unit, units.of(name)) is not None for bare, unit in parted],
        [bare == name for bare, _ in parted],
    )
    return next((way.index(True) for way in ways if True in way), None)


def _unit_text(cell: str) -> str:
    return cell.strip("[]() ")


def _is_unit(cell: str) -> bool:
    tables = (units.TIME, units.ANGLE)
    return any(units.named(_unit_text(cell), table) is not None for table in tables)
