"""Excel workbooks (.xlsx), by openpyxl."""

from pathlib import Path

import numpy as np

from tp_jax.recordings.faults import listed
from tp_jax.recordings.readers import Unreadable

Cell = object

_MOST_TITLES = 200


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:
    """The columns of a sheet, below the last row of titles; see the package."""
    from openpyxl import load_workbook

    book = load_workbook(file, read_only=True, data_only=True)
    try:
        if sheet is not None and sheet not in book.sheetnames:
            raise Unreadable(
                f'there is no sheet "{sheet}" among {listed(book.sheetnames)}',
                "correct sheet under [format]",
            )
        chosen = book[book.sheetnames[0] if sheet is None else sheet]
        rows = [row for row in chosen.iter_rows(values_only=True) if any(_there(c) for c in row)]
    finally:
        book.close()
    first = next((i for i, row in enumerate(rows[:_MOST_TITLES]) if _is_row(row)), None)
    if first is None:
        raise Unreadable(
            "the sheet has no rows of numbers", "name another with sheet under [format]"
        )
    names = rows[first - 1] if first else ()
    width = max(len(row) for row in rows[first:])
    used = [j for j in range(width) if any(j < len(r) and _there(r[j]) for r in rows[first:])]
    columns = {}
    for j in used:
        told = str(names[j]).strip() if j < len(names) and _there(names[j]) else f"column {j}"
        name = told if told not in columns else f"{told} ({j})"
        columns[name] = np.array([row[j] if j < len(row) else None for row in rows[first:]], object)
    return columns


def _there(cell: Cell) -> bool:
    return cell is not None and str(cell).strip() != ""


def _is_row(row: tuple) -> bool:
    """True if more than half of the cells that are filled hold no text."""
    filled = [cell for cell in row if _there(cell)]
    return 2 * sum(not isinstance(cell, str) for cell in filled) > len(filled) > 1
