"""Reading data files: where in a file the columns t, phi1, phi2 and drive are.

Three kinds are read: CSV with a header `t,phi1,phi2` (phi2, drive and further columns as they
come), the paper's three columns without a header, and files of other makers, which a `FileFormat`
describes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tp_jax.recordings.cells import number, parse, split
from tp_jax.recordings.faults import CampaignError, listed, nearest
from tp_jax.recordings.lines import Lines, read_lines

NAMES = ("t", "phi1", "phi2", "drive")
"""The columns a recording can have."""

REQUIRED = ("t", "phi1")

_MAP = " or say where it is under [format.columns] in campaign.toml"


@dataclass(frozen=True)
class ColumnSource:
    """Where a column comes from: `value = scale * cell + offset`.

    Attributes:
        column: its name in the file's header, or its 0-based index.
        scale: unit of the recording per unit of the file.
        offset: in the recording's unit.
    """

    column: str | int
    scale: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class FileFormat:
    """How a file is laid out; what is None is found out from the file.

    Attributes:
        delimiter: one character; " " stands for any white space.
        decimal: "." or ",".
        skip_lines: number of header lines, blank ones not counted.
        columns: name in the recording -> where it is in the file; empty: by the file's header,
            or in the order t, phi1, phi2.
    """

    delimiter: str | None = None
    decimal: str = "."
    skip_lines: int | None = None
    columns: Mapping[str, ColumnSource] = field(default_factory=dict)


@dataclass(frozen=True)
class Columns:
    """What was read from a file.

    Attributes:
        file: the file.
        values: name -> (n,) values, scaled.
        numbers: 1-based line in the file of each of the n rows.
        header: 1-based line of the header; None where there is none.
        sha256: of the file's bytes.
    """

    file: Path
    values: Mapping[str, np.ndarray]
    numbers: Sequence[int]
    header: int | None
    sha256: str


def read_columns(
    file: Path, form: FileFormat | None = None, wanted: Sequence[str] = NAMES
) -> Columns:
    """Reads the columns of a data file.

    Args:
        file: the data file.
        form: its format; None: CSV with a header, or the paper's three columns.
        wanted: names of the columns to read; t and phi1 must be there, others are left out
            where the file does not have them.

    Raises:
        CampaignError: the file, one of its columns or one of its cells cannot be read.
    """
    form = FileFormat() if form is None else form
    lines = read_lines(file)
    first = _first_row(lines, form)
    if first >= len(lines.text):
        raise CampaignError(
            file,
            "the file has a header but no rows",
            "record it again, or correct skip_lines under [format]",
            lines.numbers[-1],
        )
    # A header of our own has as many cells as the rows; a maker's need not.
    like = first - 1 if first and form.skip_lines is None else first
    delimiter = _delimiter(lines.text[like], form)
    header = split(lines.text[first - 1].lstrip("# "), delimiter) if first else []
    row = split(lines.text[first], delimiter)
    where = _positions(lines, first, header, row, form, wanted)
    values = parse(
        lines,
        first,
        {name: position for name, (position, _) in where.items()},
        delimiter,
        form.decimal,
        model_row=like,
    )
    for name, (_, source) in where.items():
        if (source.scale, source.offset) != (1.0, 0.0):
            values[name] = values[name] * source.scale + source.offset
    return Columns(
        file=file,
        values=values,
        numbers=lines.numbers[first:],
        header=lines.numbers[first - 1] if first else None,
        sha256=lines.sha256,
    )


def _first_row(lines: Lines, form: FileFormat) -> int:
    """Index of the first row of numbers: 0 or 1 where the format does not say."""
    if form.skip_lines is not None:
        return form.skip_lines
    cells = split(lines.text[0].lstrip("# "), _delimiter(lines.text[0], form))
    named = {*NAMES, *(source.column for source in form.columns.values())}
    # A first row with one bad cell must not pass for a header.
    is_header = any(cell in named for cell in cells) or not any(
        number(cell, form.decimal) is not None for cell in cells
    )
    return int(is_header)


def _delimiter(line: str, form: FileFormat) -> str | None:
    if form.delimiter is not None:
        return None if form.delimiter == " " else form.delimiter
    if form.decimal == ".":
        return "," if "," in line else None
    return ";" if ";" in line else None


def _positions(
    lines: Lines,
    first: int,
    header: list[str],
    row: list[str],
    form: FileFormat,
    wanted: Sequence[str],
) -> dict[str, tuple[int, ColumnSource]]:
    if form.columns:
        sources = dict(form.columns)
    elif not header:
        sources = _unnamed(lines, row)
    else:
        sources = {name: ColumnSource(name) for name in NAMES if name in header}
        for name in REQUIRED:
            sources.setdefault(name, ColumnSource(name))  # a fault below
    found = {}
    for name in wanted:
        if name in sources:
            source = sources[name]
            found[name] = (_position(lines, first, name, source.column, header, row), source)
    return found


def _unnamed(lines: Lines, row: list[str]) -> dict[str, ColumnSource]:
    cells = row[:-1] if row[-1] == "" else row  # a delimiter after the last cell
    if len(cells) not in (2, 3):
        raise CampaignError(
            lines.file,
            f"a file without a header must have the columns t, phi1, phi2, but has {len(cells)}",
            'begin it with the header "t,phi1,phi2", or describe it under [format]',
            lines.numbers[0],
        )
    return {name: ColumnSource(i) for i, name in zip(range(len(cells)), NAMES, strict=False)}


def _position(
    lines: Lines, first: int, name: str, column: str | int, header: list[str], row: list[str]
) -> int:
    if isinstance(column, int):
        if column < len(row):
            return column
        raise CampaignError(
            lines.file,
            f"there is no column {column} for {name}, the row has the columns 0 to {len(row) - 1}",
            "correct the index under [format.columns], or the delimiter under [format]",
            lines.numbers[first],
        )
    if column in header:
        return header.index(column)
    if not header:
        raise CampaignError(
            lines.file,
            f'there is no header to find the column "{column}" in',
            "give skip_lines under [format], or the column's 0-based index",
            lines.numbers[first],
        )
    near = nearest(column, [cell for cell in header if cell not in NAMES])
    raise CampaignError(
        lines.file,
        f'there is no column "{column}" among {listed(header)}',
        f'rename "{near}"{_MAP}' if near else f"rename the one that is meant{_MAP}",
        lines.numbers[first - 1],
    )
