"""Columns as they were read from a file, and which of its columns they are."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings.faults import listed, nearest
from tp_jax.recordings.short import short_fields
from tp_jax.recordings.sources import NAMES, ColumnSource, FileFormat, toml_table
from tp_jax.recordings.units import parted

MAP = " or say where it is under [format.columns] in campaign.toml, which `tp-jax init` writes"


@dataclass(frozen=True)
class Columns:
    """Columns that were read from a file.

    Attributes:
        file: the file.
        values: name -> (n,) values, scaled.
        numbers: 1-based line in the file of each of the n rows.
        header: 1-based line of the header; None where there is none.
        sha256: of the file's bytes.
        sources: name -> where it came from; empty without a file.
        form: the format it was read by.
        dated: times were written as dates or clock times.
        zoned: dates that tell their offset from UTC, so that no summer time is in them.
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
    zoned: bool = False
    notes: tuple[str, ...] = ()
    thinned: bool = False

    def advice(self, changes: Mapping[str, Mapping[str, Any]], alone: bool = False) -> str:
        """Says what to write in a campaign.toml for columns to be read with other settings.

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


def changed(sources: Mapping[str, ColumnSource], form: FileFormat) -> dict[str, ColumnSource]:
    """The sources with what one file has of its own."""
    out = dict(sources)
    for name, given in form.changes.items():
        out[name] = out.get(name, ColumnSource(name)).changed(given)
    return out


def chosen_sources(
    sources: Mapping[str, ColumnSource],
    wanted: Sequence[str],
    fault: Callable[[str, str], Exception],
) -> dict[str, ColumnSource]:
    """The sources of the columns wanted, and of those that they are counted from.

    Raises:
        Exception: what `fault(wrong, mend)` makes, where a column is counted from none.
    """
    needed = [name for name in wanted if name in sources]
    for name in needed:  # grows: what is taken off may itself be counted from another
        minus = sources[name].minus
        if minus is None or minus in needed:
            continue
        if minus not in sources:
            raise fault(
                f'minus of {name} is "{minus}", a column that the file does not have',
                f"remove minus of {name} under [format.columns] or beside the file, or add {minus} "
                "to the file",
            )
        needed.append(minus)
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
