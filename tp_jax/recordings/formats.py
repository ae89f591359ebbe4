"""Reading data files: where in a file the columns t, phi1, phi2 and drive are.

Read are CSV with a header `t,phi1,phi2` (phi2, drive and further columns as they come), the
paper's three columns without a header, texts of other makers, whose layout is found out or
described by a `FileFormat`, and files of other kinds, each by a library (`tables`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tp_jax.recordings.cells import parse, split
from tp_jax.recordings.faults import CampaignError, listed, nearest
from tp_jax.recordings.kinds import kind_of
from tp_jax.recordings.layout import Layout, layout_of
from tp_jax.recordings.lines import Lines, as_lines, read_bytes
from tp_jax.recordings.sources import NAMES as NAMES
from tp_jax.recordings.sources import REQUIRED as REQUIRED
from tp_jax.recordings.sources import ColumnSource as ColumnSource
from tp_jax.recordings.sources import FileFormat as FileFormat
from tp_jax.recordings.sources import from_header, values_of
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
    lines = as_lines(file, raw)
    layout = layout_of(lines, form)
    if layout.first >= len(lines.text):
        raise CampaignError(
            file,
            "the file has a header but no rows",
            "record it again, or correct skip_lines under [format]",
            lines.numbers[-1],
        )
    row = split(lines.text[layout.first], layout.delimiter)
    sources = _sources(lines, layout, row, form)
    chosen = chosen_sources(sources, wanted)
    positions = {
        name: _position(lines, layout, name, source.column, row) for name, source in chosen.items()
    }
    cells = parse(
        lines, layout.first, positions, layout.delimiter, layout.decimal, model_row=layout.like
    )
    values = values_of(chosen, cells)
    return Columns(
        file=file,
        values={name: values[name] for name in wanted if name in values},
        numbers=lines.numbers[layout.first :],
        header=None if layout.header_at is None else lines.numbers[layout.header_at],
        sha256=lines.sha256,
    )


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
