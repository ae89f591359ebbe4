"""Reading data files: where in a file the columns t, phi1, phi2 and drive are.

Read are CSV with a header `t,phi1,phi2` (phi2, drive and further columns as they come), the
paper's three columns without a header, texts of other makers, whose layout is found out or
described by a `FileFormat`, and files of other kinds, each by a library (`tables`).
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from tp_jax.recordings.cells import parse, split
from tp_jax.recordings.clock_times import has_zone, is_date_or_clock
from tp_jax.recordings.columns import Columns, changed, chosen_sources, position_by_name
from tp_jax.recordings.faults import CampaignError, in_rows
from tp_jax.recordings.joined import check_joined
from tp_jax.recordings.kinds import kind_of
from tp_jax.recordings.layout import Layout, layout_of
from tp_jax.recordings.lines import Lines, as_lines, read_bytes, without_separators
from tp_jax.recordings.readings import readings
from tp_jax.recordings.sources import NAMES as NAMES
from tp_jax.recordings.sources import REQUIRED as REQUIRED
from tp_jax.recordings.sources import ColumnSource as ColumnSource
from tp_jax.recordings.sources import FileFormat as FileFormat
from tp_jax.recordings.sources import from_header
from tp_jax.recordings.tables import read_table


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
    sources = changed(_sources(lines, layout, row, form, wanted), form)
    chosen = chosen_sources(sources, wanted, _faults(lines, layout))
    positions = {
        name: _position(lines, layout, name, source.column, row) for name, source in chosen.items()
    }
    check_joined(lines, layout, positions.get("t"))
    cells = parse(
        lines, layout.first, positions, layout.delimiter, layout.decimal, model_row=layout.like
    )
    first = row[positions["t"]]
    dated, zoned = is_date_or_clock(first), has_zone(first)
    read = readings(file, chosen, cells, dated=dated, zoned=zoned, held=form.held)
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
        zoned=zoned,
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


def _sources(
    lines: Lines, layout: Layout, row: list[str], form: FileFormat, wanted: Sequence[str]
) -> dict[str, ColumnSource]:
    if form.columns:
        return dict(form.columns)
    names = layout.header or layout.unlike
    if names:
        return from_header(names, layout.below, form.changes, wanted, _faults(lines, layout))
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
    names = layout.header or layout.unlike
    if not names:
        raise CampaignError(
            lines.file,
            f'there is no header to find the column "{column}" in',
            "give skip_lines under [format], or the column's 0-based index",
            lines.numbers[layout.first],
        )
    fault = _faults(lines, layout)
    position = position_by_name(column, names, fault)
    if layout.unlike:
        raise fault(
            f"the line with the columns' names has {len(names)} cells between white space, and the "
            f"rows have {len(row)}, so that it is unknown which column {column} is",
            "give all columns by their 0-based index, with their units, under [format.columns] in "
            'campaign.toml, as in t = { column = 0, unit = "s" }',
        )
    return position


def _faults(lines: Lines, layout: Layout) -> Callable[[str, str], CampaignError]:
    """Returns a function that makes faults in the line with the columns' names."""
    at = None if layout.header_at is None else lines.numbers[layout.header_at]
    return lambda wrong, mend: CampaignError(lines.file, wrong, mend, at)
