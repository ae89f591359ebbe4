"""MATLAB files up to version 7, by SciPy; later ones are HDF5."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tp_jax.recordings.readers.matrices import columns


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:
    """The vectors and matrices of the file, fields of structs as "struct.field"."""
    from scipy.io import loadmat

    content = loadmat(file, squeeze_me=True, struct_as_record=False)
    named = ((n, v) for n, v in content.items() if not n.startswith("__"))
    return columns(pair for name, value in named for pair in _arrays(name, value, sheet))


def _arrays(name: str, value: object, only: str | None) -> Iterator[tuple[str, np.ndarray]]:
    if only is not None and name.split(".")[0] != only:
        return
    fields = getattr(value, "_fieldnames", None)
    if fields is None:
        yield name, np.asarray(value)
        return
    for field in fields:
        yield from _arrays(f"{name}.{field}", getattr(value, field), only)
