"""Rows of text to numbers: fast where all is well, and cell by cell where it is not."""

from collections.abc import Mapping
from typing import NoReturn

import numpy as np

from tp_jax.recordings.clock_times import is_date_or_clock, seconds_since_first
from tp_jax.recordings.faults import CampaignError, in_rows, shortened
from tp_jax.recordings.lines import Lines


def split(line: str, delimiter: str | None) -> list[str]:
    """Cells of a line, stripped of blanks and quotes; delimiter None: any white space."""
    return [cell.strip().strip('"').strip() for cell in line.split(delimiter)]


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
    try:
        values = np.loadtxt(
            rows if decimal == "." else [row.replace(decimal, ".") for row in rows],
            delimiter=delimiter,
            usecols=list(positions.values()),
            comments=None,
            ndmin=2,
        )
    except ValueError:
        # Either a fault, whose place is found now, or quotes, which the fast way does not take.
        values = _cell_by_cell(lines, first, positions, delimiter, decimal)
    return {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(positions)}


def _check_widths(lines: Lines, first: int, delimiter: str | None, model_row: int) -> None:
    if delimiter is None:
        widths = [len(row.split()) for row in lines.text]
    else:
        widths = [row.count(delimiter) + 1 for row in lines.text]
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
    empty = cell == ""
    raise CampaignError(
        lines.file,
        f'{name} is not a number but "{shortened(cell)}"{more}',
        f"remove the {'row' if len(at) == 1 else 'rows'}, a gap in time is understood"
        if empty
        else "write a number there, or set delimiter and decimal under [format]",
        lines.numbers[at[0]],
    )
