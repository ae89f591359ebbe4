"""Rows of text to numbers: fast where all is well, and cell by cell where it is not."""

import csv
import re
from collections.abc import Mapping
from typing import NoReturn

import numpy as np

from tp_jax.recordings.clock_times import (
    FORMS,
    day_or_month,
    is_date_or_clock,
    seconds_since_first,
)
from tp_jax.recordings.faults import CampaignError, in_rows, shortened
from tp_jax.recordings.lines import Lines

_TITLE = re.compile(r"\S+(?:\s+(?:\[[^\]]*\]|\([^)]*\)|/\s*\S+))*")
"""A word, and the units behind it that stand as words of their own: "t [s]", "t (s)", "t / s"."""


def split(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line, stripped of blanks and quotes; delimiter None: any white space.

    A delimiter in quotes parts nothing: `"0,004","1,23"` are two cells.
    """
    cells = line.split(delimiter)
    if delimiter is not None and '"' in line and any(cell.count('"') % 2 for cell in cells):
        # a quote without another, as of inches, must not swallow the rest of the line
        if line.count('"') % 2 == 0 and len(line) < csv.field_size_limit():
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip().strip('"').strip() for cell in cells]


def split_title(line: str, delimiter: str | None, width: int) -> list[str]:
    """Cells of a line above the rows, which have `width` cells.

    Between white space a unit may stand as a word of its own, as NumPy's `savetxt` writes a
    header: it belongs to the name before it, unless the words are as many as the cells of a row.
    """
    cells = split(line, delimiter)
    if delimiter is not None or len(cells) == width:
        return cells
    return [" ".join(cell.replace('"', " ").split()) for cell in _TITLE.findall(line)]


def number(cell: str, decimal: str) -> float | None:
    """The number in a cell (NaN and infinity are numbers here), or None."""
    if "_" in cell:  # Python's 1_000; no instrument writes it
        return None
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return None


def parse(
    lines: Lines,
    first: int,
    positions: Mapping[str, int],
    delimiter: str | None,
    decimal: str,
    model_row: int,
) -> dict[str, np.ndarray]:
    """Parses the columns asked for.

    Args:
        lines: of the file.
        first: index in `lines` of the first row of numbers.
        positions: name of each column wanted -> its 0-based index in the file.
        delimiter: between cells; None: any white space.
        decimal: "." or ",".
        model_row: index of the line whose number of cells all rows must have.

    Returns:
        Name -> (n,) float array, in the file's units.

    Raises:
        CampaignError: a row of another length, or a cell that is no number.
    """
    rows = lines.text[first:]
    _check_widths(lines, first, delimiter, model_row)
    # Quotes, within which a delimiter parts nothing, the fast way does not take. Where it fails
    # there is a fault, whose place is found cell by cell.
    values = None
    if not any('"' in row for row in rows):
        values = _at_once(rows, positions, delimiter, decimal)
    if values is None:
        values = _cell_by_cell(lines, first, positions, delimiter, decimal)
    return {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(positions)}


def _at_once(
    rows: list[str], positions: Mapping[str, int], delimiter: str | None, decimal: str
) -> np.ndarray | None:
    """(n, columns) numbers; None where a cell is none."""
    try:
        return np.loadtxt(
            rows if decimal == "." else [row.replace(decimal, ".") for row in rows],
            delimiter=delimiter,
            usecols=list(positions.values()),
            comments=None,
            ndmin=2,
        )
    except ValueError:
        return None


def _check_widths(lines: Lines, first: int, delimiter: str | None, model_row: int) -> None:
    if delimiter is None:
        widths = [len(row.split()) for row in lines.text]
    else:
        widths = [
            len(split(row, delimiter)) if '"' in row else row.count(delimiter) + 1
            for row in lines.text
        ]
    wanted = widths[model_row]
    if widths[first:] == [wanted] * (len(widths) - first):
        return
    bad = next(i for i in range(first, len(widths)) if widths[i] != wanted)
    raise CampaignError(
        lines.file,
        f"the row has {_cells(widths[bad])} where line {lines.numbers[model_row]} has {wanted}",
        "complete or remove it",
        lines.numbers[bad],
    )


def _cells(n: int) -> str:
    return f"{n} cell" if n == 1 else f"{n} cells"


def _cell_by_cell(
    lines: Lines, first: int, positions: Mapping[str, int], delimiter: str | None, decimal: str
) -> np.ndarray:
    rows = [split(line, delimiter) for line in lines.text[first:]]
    _check_reach(lines, first, rows, positions)
    values = np.empty((len(rows), len(positions)))
    for j, (name, position) in enumerate(positions.items()):
        column = [row[position] for row in rows]
        if name == "t" and is_date_or_clock(column[0]):
            values[:, j], bad = seconds_since_first(column)
            wrong = [] if bad is None else [bad]
        else:
            numbers = [number(cell, decimal) for cell in column]
            wrong = [i for i, value in enumerate(numbers) if value is None]
            if not wrong:
                values[:, j] = numbers
        if wrong:
            _refuse(lines, name, column, [first + i for i in wrong], first)
    return values


def _check_reach(
    lines: Lines, first: int, rows: list[list[str]], positions: Mapping[str, int]
) -> None:
    """Faults the first row that ends before a column that is wanted."""
    name = max(positions, key=lambda each: positions[each])
    for i, row in enumerate(rows):
        if len(row) <= positions[name]:
            raise CampaignError(
                lines.file,
                f"the row has {_cells(len(row))}, too few for {name} in column "
                f"{positions[name] + 1}",
                "complete or remove it",
                lines.numbers[first + i],
            )


def _refuse(lines: Lines, name: str, column: list[str], at: list[int], first: int) -> NoReturn:
    """Faults cells that are no numbers, all of a column at once."""
    cell = column[at[0] - first]
    more = in_rows([lines.numbers[i] for i in at])
    mend = "write a number there, or set delimiter and decimal under [format]"
    if cell == "":
        mend = f"remove the {'row' if len(at) == 1 else 'rows'}, a gap in time is understood"
    elif name == "t" and (":" in cell or day_or_month(cell)):
        mend = FORMS
    raise CampaignError(
        lines.file,
        f'{name} is not a number but "{shortened(cell)}"{more}'
        + (", of which the day may be either number" if day_or_month(cell) else ""),
        mend,
        lines.numbers[at[0]],
    )
