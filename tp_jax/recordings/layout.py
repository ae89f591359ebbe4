"""Layout of a text file: what parts its cells, its decimal sign, where its rows begin."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tp_jax.recordings import units
from tp_jax.recordings.cells import number, split, split_title
from tp_jax.recordings.clock_times import is_date_or_clock
from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.lines import Lines
from tp_jax.recordings.sources import NAMES, FileFormat

LONGEST_HEADER = 200
"""Lines above the first row that are looked at; makers' programs write 5 to 60."""

_SAMPLE = 25
"""Rows from the middle of the file by which the cells are found."""


@dataclass(frozen=True)
class Layout:
    """Layout of a text file: where its cells are.

    Attributes:
        delimiter: between cells; None: any white space.
        decimal: "." or ",".
        first: index in the lines of the first row of numbers.
        header: cells of the line with the columns' names; empty where there is none.
        unlike: the same of a line whose cells between white space are more or fewer than those of
            a row, so that they name none of its columns for certain; empty where they are as many.
        header_at: index of that line; None where there is none.
        below: cells of the line between the header and the rows, which may hold units.
        like: index of the line whose number of cells all rows must have.
        numeric: of the columns by index, those that hold numbers, dates or clock times.
        width: number of cells in a row.
    """

    delimiter: str | None
    decimal: str
    first: int
    header: list[str]
    unlike: list[str]
    header_at: int | None
    below: list[str]
    like: int
    numeric: tuple[int, ...]
    width: int


def layout_of(lines: Lines, form: FileFormat) -> Layout:
    """The layout of a file; what the format says is taken as said."""
    text = lines.text
    begin = min(form.skip_lines or 0, len(text) - 1)
    middle = max(begin, len(text) // 2)
    sample = text[middle : middle + _SAMPLE]
    delimiter, decimal, width, numeric = _parts(lines.file, sample, form)

    def cells(i: int) -> list[str]:
        line = text[i].lstrip("# ") if i < LONGEST_HEADER else text[i]
        return split_title(line, delimiter, width)

    named = {*NAMES, *(source.column for source in form.columns.values())}

    def is_title(i: int) -> bool:
        row = cells(i)
        numbers = [is_number(cell, decimal) for cell in row]
        if not any(numbers) or any(cell in named for cell in row):
            return True
        return form.skip_lines is None and len(row) != width and not all(numbers)

    def is_row(i: int) -> bool:
        row = cells(i)
        return len(row) == width and all(is_number(row[j], decimal) for j in numeric)

    # A row with a bad cell must not pass for a header: titles end where a whole row stands.
    limit = min(len(text), begin + LONGEST_HEADER)
    until = next((i for i in range(begin, limit) if is_row(i) and not is_title(i)), None)
    if until is None:
        first = next((i for i in range(begin, limit) if not is_title(i)), limit)
    else:
        first = 1 + max((i for i in range(begin, until) if is_title(i)), default=begin - 1)
    if form.skip_lines is not None:
        first = max(first, form.skip_lines)
    header_at = _header(first, cells, named)
    header = [] if header_at is None else cells(header_at)
    below = cells(header_at + 1) if header_at is not None and header_at + 1 < first else []
    own = form.skip_lines is None and header_at is not None and len(header) == width
    if own and header_at is not None and delimiter is None:
        # joined cells, or a "#" before them, make the line itself no model for the rows
        own = len(text[header_at].split()) == width
    like = header_at if own and header_at is not None else min(first, len(text) - 1)
    unlike = header if delimiter is None and len(header) != width else []
    return Layout(
        delimiter,
        decimal,
        first,
        [] if unlike else header,
        unlike,
        header_at,
        below,
        like,
        numeric,
        width,
    )


def is_number(cell: str, decimal: str) -> bool:
    """True if a cell holds a number, a date or a clock time."""
    return number(cell, decimal) is not None or is_date_or_clock(cell)


def _parts(
    file: Path, sample: list[str], form: FileFormat
) -> tuple[str | None, str, int, tuple[int, ...]]:
    """Delimiter, decimal sign, cells in a row, and the columns of numbers."""
    if form.delimiter is not None:
        delimiters = [None if form.delimiter == " " else form.delimiter]
    else:
        # who writes tabs or semicolons means them; a comma or a blank may be something else
        delimiters = [d for d in ("\t", ";") if all(d in line for line in sample)] or [",", None]
    decimals = [form.decimal] if form.decimal is not None else [".", ","]
    best = None
    for delimiter in delimiters:
        for decimal in decimals:
            # a decimal comma in quotes is known from a comma between cells
            if delimiter == decimal and not any('"' in line for line in sample):
                continue
            width, numeric = _columns(sample, delimiter, decimal)
            score = (len(numeric) > 1, len(numeric) / width, len(numeric))
            if best is None or score > best[0]:
                best = score, (delimiter, decimal, width, numeric)
    if best is None:
        raise CampaignError(
            file,
            f'delimiter and decimal are both "{form.decimal}" under [format], but the cells are '
            "not in quotes",
            "say which of them it is",
        )
    return best[1]


def _columns(sample: list[str], delimiter: str | None, decimal: str) -> tuple[int, tuple[int, ...]]:
    rows = [split(line, delimiter) for line in sample]
    width = Counter(map(len, rows)).most_common(1)[0][0]
    rows = [row for row in rows if len(row) == width]
    # a column of numbers with a bad cell or two is one still
    numeric = tuple(
        j for j in range(width) if 2 * sum(is_number(row[j], decimal) for row in rows) > len(rows)
    )
    return width, numeric


def _header(first: int, cells: Callable[[int], list[str]], named: set) -> int | None:
    """Index of the line with the columns' names: with those asked for, or the last above rows."""
    if first == 0:
        return None
    above = range(first - 1, max(-1, first - 1 - LONGEST_HEADER), -1)
    for i in above:
        if any(cell in named or units.parted(cell)[0] in named for cell in cells(i)):
            return i
    if first > 1 and _all_units(cells(first - 1)):
        return first - 2
    return first - 1


def _all_units(row: list[str]) -> bool:
    told = [cell.strip("[]() ") for cell in row]
    tables = (units.TIME, units.ANGLE, units.FREQUENCY, {"V": 1.0, "mV": 1.0, "-": 1.0, "": 1.0})
    known = [any(units.named(cell, table) is not None for table in tables) for cell in told]
    return any(told) and all(known)
