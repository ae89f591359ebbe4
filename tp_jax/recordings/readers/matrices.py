"""Arrays of any shape as columns, for files that hold arrays by name."""

from collections.abc import Iterable

import numpy as np


def columns(arrays: Iterable[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """One-dimensional columns: vectors as they are, matrices column by column.

    A matrix that is wider than long is taken row by row. What is no column of numbers, or shorter
    than three samples, is left out.
    """
    found: dict[str, np.ndarray] = {}
    for name, array in arrays:
        array = np.asarray(array)
        if array.dtype.kind not in "fiuMmb" or array.size < 3:
            continue
        array = np.squeeze(array)
        if array.ndim == 1:
            found[name] = array
        elif array.ndim == 2:
            tall = array if array.shape[0] >= array.shape[1] else array.T
            found |= {f"{name}[{j}]": tall[:, j] for j in range(tall.shape[1])}
    return found
