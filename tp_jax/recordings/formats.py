"""Reading data files: where in a file the columns t, phi1, phi2 and drive are.

Read are CSV with a header `t,phi1,phi2` (phi2, drive and further columns as they come), the
paper's three columns without a header, texts of other makers, whose layout is found out or
described by a `FileFormat`, and files of other kinds, each by a library (`tables`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings.cells import parse, split
from tp_jax.recordings.clock_times import is_date_or_clock
from tp_jax.recordings.faults import CampaignError, in_rows, listed, nearest
from tp_jax.recordings.joined import check_joined
from tp_jax.recordings.kinds import kind_of
from tp_jax.recordings.layout import Layout, layout_of
from tp_jax.recordings.lines import Lines, as_lines, read_bytes, without_separators
from tp_jax.recordings.readings import readings
from tp_jax.recordings.short import short_fields
from tp_jax.recordings.sources import NAMES as NAMES
from tp_jax.recordings.sources import REQUIRED as REQUIRED
from tp_jax.recordings.sources import ColumnSource as ColumnSource
from tp_jax.recordings.sources import FileFormat as FileFormat
from tp_jax.recordings.sources import from_header, toml_table
from tp_jax.recordings.units import parted

MAP = " or say where it is under [format.columns] in campaign.toml, which `tp-jax init` writes"


@dataclass(frozen=True)
class Columns:
    """What was read from a file.

    Attributes:
        file: the file.
        values: name -> (n,) values, scaled.
        numbers: 1-based line in the file of each of the n rows.
        header: 1-based line of the header; None where there is none.
        sha256: of the file's bytes.
        sources: name -> where it came from; empty without a file.
        form: the format it was read by.
        dated: times were written as dates or clock times.
        notes: what was done to the rows, a sentence each, without its end.
        thinned: of rows that say the same only one was kept.
    """

    __repr__ = short_fields

    file: Path
    values: Mapping[str, np.ndarray]
    numbers: Sequence[int]
    header: int | None
    sha256: str
    sources: Mapping[str, ColumnSource] = field(default_factory=dict)
    form: FileFormat = field(default_factory=FileFormat)
    dated: bool = False
    notes: tuple[str, ...] = ()
    thinned: bool = False

    def advice(self, changes: Mapping[str, Mapping[str, Any]], alone: bool = False) -> str:
        """What to write in a campaign.toml for columns to be read with other settings.

        Args:
            changes: name of a column -> its settings.
            alone: other files are not to be read like that.
        """
        if alone:
            return f'write columns = {toml_table(changes)} beside file = "{self.file.name}"'
        whole = bool(self.form.columns)
        told = ", ".join(
            f"{name} = "
            + (
                self.sources[name].changed(given).toml()
                if whole
                else toml_table({**self.form.changes.get(name, {}), **given})
            )
            for name, given in changes.items()
        )
        return f"write {told} under [format.columns]"


def read_columns(
    file: Path, form: FileFormat | None = None, wanted: Sequence[str] = NAMES
) -> Columns:
    """Reads the columns of a data file.

    Args:
        file: the data file.
        form: its format; None: found out from the file.
        wanted: names of the columns to read; t and phi1 must be there, others are left out
            where the file does not have them.

    Raises:
        CampaignError: the file, one of its columns or one of its cells cannot be read.
    """
    form = FileFormat() if form is None else form
    raw = read_bytes(file)
    kind = kind_of(file, raw[:4096])
    if kind is not None:
        from tp_jax.recordings.tables import read_table

        return read_table(file, raw, kind, form, wanted)
    lines, left_out = without_separators(as_lines(file, raw), form.skip_lines or 0)
    layout = layout_of(lines, form)
    if layout.first >= len(lines.text):
        raise CampaignError(
            file,
            "the file has a header but no rows",
            "record it again, or correct skip_lines under [format]",
            lines.numbers[-1],
        )
    row = split(lines.text[layout.first], layout.delimiter)
    sources = changed(_sources(lines, layout, row, form), form)
    chosen = chosen_sources(sources, wanted)
    positions = {
        name: _position(lines, layout, name, source.column, row) for name, source in chosen.items()
    }
    check_joined(lines, layout, positions.get("t"))
    cells = parse(
        lines, layout.first, positions, layout.delimiter, layout.decimal, model_row=layout.like
    )
    dated = is_date_or_clock(row[positions["t"]])
    read = readings(file, chosen, cells, dated=dated, held=form.held)
    numbers = lines.numbers[layout.first :]
    return Columns(
        file=file,
        values={name: read.values[name] for name in wanted if name in read.values},
        numbers=numbers if read.rows.size == len(numbers) else [numbers[i] for i in read.rows],
        header=None if layout.header_at is None else lines.numbers[layout.header_at],
        sha256=lines.sha256,
        sources=chosen,
        form=form,
        dated=dated,
        notes=(*empty_rows(file, left_out, lines.numbers[layout.first]), *read.notes),
        thinned=read.rows.size < len(numbers),
    )


def empty_rows(file: Path, left_out: Sequence[int], first: int) -> tuple[str, ...]:
    """A note of rows of separators only, those above the first row of numbers not counted."""
    among = [number for number in left_out if number > first]
    if not among:
        return ()
    told = in_rows(among) or f", in line {among[0]}"
    return (f"{file}: empty rows, of separators only, were left out{told}",)


def changed(sources: Mapping[str, ColumnSource], form: FileFormat) -> dict[str, ColumnSource]:
    """The sources with what one file has of its own."""
    out = dict(sources)
    for name, given in form.changes.items():
        out[name] = out.get(name, ColumnSource(name)).changed(given)
    return out


def chosen_sources(
    sources: Mapping[str, ColumnSource], wanted: Sequence[str]
) -> dict[str, ColumnSource]:
    """The sources of the columns wanted, and of those that they are counted from."""
    needed = [name for name in wanted if name in sources]
    needed += [m for n in needed if (m := sources[n].minus) is not None and m not in needed]
    return {name: sources[name] for name in needed}


def position_by_name(
    column: str, header: Sequence[str], fault: Callable[[str, str], Exception]
) -> int:
    """Index of a column in a header: by its whole cell, or by its name before the unit.

    Raises:
        Exception: what `fault(wrong, mend)` makes, where there is no such column.
    """
    for cells in (list(header), [parted(cell)[0] for cell in header]):
        if column in cells:
            return cells.index(column)
    near = nearest(column, [cell for cell in header if cell not in NAMES])
    raise fault(
        f'there is no column "{column}" among {listed(header)}',
        f'rename "{near}"{MAP}' if near else f"rename the one that is meant{MAP}",
    )


def _sources(
    lines: Lines, layout: Layout, row: list[str], form: FileFormat
) -> dict[str, ColumnSource]:
    if form.columns:
        return dict(form.columns)
    if layout.header:
        return from_header(layout.header, layout.below)
    cells = row[:-1] if row[-1] == "" else row  # a delimiter after the last cell
    if len(cells) not in (2, 3):
        raise CampaignError(
            lines.file,
            f"a file without a header must have the columns t, phi1, phi2, but has {len(cells)}",
            'begin it with the header "t,phi1,phi2", or describe it under [format], which '
            "`tp-jax init` writes",
            lines.numbers[0],
        )
    return {name: ColumnSource(i) for i, name in zip(range(len(cells)), NAMES, strict=False)}


def _position(lines: Lines, layout: Layout, name: str, column: str | int, row: list[str]) -> int:
    if isinstance(column, int):
        if column < len(row):
            return column
        raise CampaignError(
            lines.file,
            f"there is no column {column} for {name}, the row has the columns 0 to {len(row) - 1}",
            "correct the index under [format.columns], or the delimiter under [format]",
            lines.numbers[layout.first],
        )
    if not layout.header:
        raise CampaignError(
            lines.file,
            f'there is no header to find the column "{column}" in',
            "give skip_lines under [format], or the column's 0-based index",
            lines.numbers[layout.first],
        )
    at = None if layout.header_at is None else lines.numbers[layout.header_at]
    return position_by_name(
        column, layout.header, lambda wrong, mend: CampaignError(lines.file, wrong, mend, at)
    )
