"""HDF5 files, MATLAB's from version 7.3 among them, by h5py."""

from pathlib import Path

import numpy as np

from tp_jax.recordings.readers import Unreadable
from tp_jax.recordings.readers.matrices import columns


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:
    """The data sets of the file or of the group `sheet`, by their paths."""
    import h5py

    found: list[tuple[str, np.ndarray]] = []

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            if item.dtype.names:  # a table of named columns, as pandas and PyTables write it
                found.extend((f"{name}/{each}", item[each]) for each in item.dtype.names)
            else:
                found.append((name, item[()]))

    with h5py.File(file, "r") as content:
        group = content if sheet is None else content[sheet]
        if not isinstance(group, h5py.Group):
            raise Unreadable(f'"{sheet}" is no group', "correct sheet under [format]")
        group.visititems(visit)
    return columns((name, array) for name, array in found)
