"""Parquet and Arrow (Feather) files, by pyarrow."""

from pathlib import Path

import numpy as np


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:  # noqa: ARG001
    """The columns of the table."""
    if file.read_bytes()[:4] == b"PAR1":
        from pyarrow.parquet import read_table  # pyright: ignore[reportMissingImports]

        table = read_table(file)
    else:
        from pyarrow.feather import read_table  # pyright: ignore[reportMissingImports]

        table = read_table(file)
    return {name: np.asarray(table.column(name).to_numpy()) for name in table.column_names}
