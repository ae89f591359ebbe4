"""Files that are no text, as columns: the reader for their kind, and what it found as numbers."""

import hashlib
import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings.cells import number
from tp_jax.recordings.clock_times import (
    FORMS,
    day_or_month,
    has_zone,
    is_date_or_clock,
    seconds_since_first,
)
from tp_jax.recordings.columns import (
    MAP,
    Columns,
    changed,
    chosen_sources,
    position_by_name,
)
from tp_jax.recordings.faults import CampaignError, listed
from tp_jax.recordings.kinds import Kind
from tp_jax.recordings.readers import Unreadable
from tp_jax.recordings.readings import readings
from tp_jax.recordings.sources import ColumnSource, FileFormat, from_header


def read_table(
    file: Path, raw: bytes, kind: Kind, form: FileFormat, wanted: Sequence[str]
) -> Columns:
    """Reads columns as `formats.read_columns` does, from a file that is no text.

    Raises:
        CampaignError: there is no reader for it, its library is missing, or a column is.
    """
    table = read_named(file, kind, form.sheet)
    names = list(table)

    def fault(wrong: str, mend: str) -> CampaignError:
        return CampaignError(file, f"this is {kind.name}, and {wrong}", mend)

    sources = changed(form.columns or from_header(names, [], form.changes, wanted, fault), form)
    chosen = chosen_sources(sources, wanted, fault)
    if not form.columns and not {"t", "phi1"} <= {*chosen} & {*_found(chosen, names)}:
        lengths = {array.size for array in table.values()}
        if len(names) in (2, 3) and len(lengths) == 1 and _of_a_matrix(names):
            chosen = {n: ColumnSource(i) for i, n in enumerate(wanted[: len(names)])}
    cells, dated, zoned = {}, False, False
    for name, source in chosen.items():
        column = _column(file, kind, name, source.column, table)
        cells[name] = as_numbers(file, name, column)
        if name == "t":
            dated, zoned = is_dated(column), is_zoned(column)
    _check_lengths(file, cells)
    read = readings(file, chosen, cells, dated=dated, zoned=zoned, held=form.held)
    return Columns(
        file=file,
        values={name: read.values[name] for name in wanted if name in read.values},
        numbers=(read.rows + 1).tolist(),
        header=None,
        sha256=hashlib.sha256(raw).hexdigest(),
        sources=chosen,
        form=form,
        dated=dated,
        zoned=zoned,
        notes=read.notes,
        thinned=read.rows.size < cells["t"].size,
    )


def read_named(file: Path, kind: Kind, sheet: str | None) -> Mapping[str, np.ndarray]:
    """The columns of a file by name, as it has them.

    Raises:
        CampaignError: there is no reader for it, its library is missing, or it cannot be read.
    """
    if kind.reader is None:
        raise CampaignError(file, f"this is {kind.name}, which is not read", kind.mend)
    reader = importlib.import_module(f"tp_jax.recordings.readers.{kind.reader}")
    try:
        table = reader.read(file, sheet)
    except ImportError as error:
        raise CampaignError(
            file,
            f"this is {kind.name}, and {error.name or 'what reads it'} is not installed",
            f"pip install 'tp-jax[{kind.extra}]', or {kind.mend}",
        ) from error
    except Unreadable as error:
        raise CampaignError(file, f"this is {kind.name}, and {error.wrong}", error.mend) from error
    except Exception as error:  # whatever a library says of a broken file
        why = " ".join(f"{type(error).__name__}: {error}".split())[:120].rstrip(".")
        raise CampaignError(
            file, f"this is {kind.name} that cannot be read ({why})", kind.mend
        ) from error
    if not table:
        raise CampaignError(file, f"this is {kind.name} without columns of numbers", kind.mend)
    return table


def _found(chosen: Mapping[str, ColumnSource], names: Sequence[str]) -> list[str]:
    return [name for name, source in chosen.items() if source.column in names]


def _of_a_matrix(names: Sequence[str]) -> bool:
    """True if names are those that the readers give to the columns of one nameless matrix."""
    base = names[0].removesuffix("[0]")
    return list(names) == [f"{base}[{j}]" for j in range(len(names))]


def _column(
    file: Path, kind: Kind, name: str, column: str | int, table: Mapping[str, np.ndarray]
) -> np.ndarray:
    names = list(table)
    if isinstance(column, int):
        if column >= len(names):
            raise CampaignError(
                file,
                f"there is no column {column} for {name}, the file has 0 to {len(names) - 1}, "
                f"{listed(names)}",
                "correct the index under [format.columns]",
            )
        column = names[column]
    elif column not in names:

        def fault(wrong: str, mend: str) -> CampaignError:
            return CampaignError(file, f"this is {kind.name}, and {wrong}", mend)

        column = names[position_by_name(column, names, fault)]
    return table[column]


def as_numbers(file: Path, name: str, cells: np.ndarray) -> np.ndarray:
    """(n,) floats: numbers as they are, dates and clock times in seconds from the first.

    Raises:
        CampaignError: a cell is neither.
    """
    if cells.dtype.kind == "M":
        return (cells - cells[0]) / np.timedelta64(1, "ns") * 1e-9
    if cells.dtype.kind == "m":
        return cells / np.timedelta64(1, "ns") * 1e-9
    if cells.dtype.kind in "fiub":
        return cells.astype(float)
    texts = [_text(cell) for cell in cells]
    if name == "t" and texts and is_date_or_clock(texts[0]):
        seconds, bad = seconds_since_first(texts)
        if bad is None:
            return seconds
    found = [number(text, ",") for text in texts]
    for i, value in enumerate(found):
        if value is None:
            raise CampaignError(
                file,
                f'{name} is not a number but "{texts[i]}"',
                FORMS
                if name == "t" and day_or_month(texts[i])
                else "write a number there, or remove the row, a gap in time is understood",
                i + 1,
            )
    return np.array(found, dtype=float)


def is_dated(cells: np.ndarray) -> bool:
    """True if cells are dates or clock times."""
    if cells.dtype.kind in "fiubm" or not cells.size:
        return False
    return cells.dtype.kind == "M" or is_date_or_clock(_text(cells[0]))


def is_zoned(cells: np.ndarray) -> bool:
    """True if cells are dates that tell their offset from UTC."""
    return cells.dtype.kind not in "fiubmM" and cells.size > 0 and has_zone(_text(cells[0]))


def _text(cell: Any) -> str:
    """A cell as text; dates of libraries write themselves in ISO's form."""
    return "" if cell is None else str(cell)


def _check_lengths(file: Path, cells: Mapping[str, np.ndarray]) -> None:
    lengths = {name: column.size for name, column in cells.items()}
    if len({*lengths.values()}) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise CampaignError(file, f"the columns differ in length, {told}", f"choose others{MAP}")
