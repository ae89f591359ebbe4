"""Writing recordings as CSV."""

import io
import os

import numpy as np
from numpy.typing import ArrayLike

from tp_jax._files import replaced


def write_csv(
    path: str | os.PathLike[str],
    t: ArrayLike,
    phi1: ArrayLike,
    phi2: ArrayLike | None = None,
    drive: ArrayLike | None = None,
) -> None:
    """Writes a recording: header `t,phi1,phi2`, or less or more of them, 17 significant digits.

    A measured drive has a column `drive` behind them.

    What is read back is bit for bit what was written. A file that is there is replaced at once
    and whole: a reader sees the old or the new one, and a failed write leaves the old.

    Args:
        path: the file; its folder must exist.
        t: (n,) times [s].
        phi1: (n,) angle of the column [rad].
        phi2: (n,) angle of the ring [rad], or None.
        drive: (n,) reading of the drive, in any unit, or None.

    Raises:
        ValueError: the columns differ in length or are not one-dimensional.
        OSError: the file cannot be written.
    """
    text = csv_text(t, phi1, phi2, drive)
    with replaced(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")


def csv_text(
    t: ArrayLike, phi1: ArrayLike, phi2: ArrayLike | None = None, drive: ArrayLike | None = None
) -> str:
    """Returns the text that `write_csv` writes.

    Raises:
        ValueError: the columns differ in length or are not one-dimensional.
    """
    columns = {"t": t, "phi1": phi1, "phi2": phi2, "drive": drive}
    columns = {name: column for name, column in columns.items() if column is not None}
    arrays = [np.asarray(column, dtype=float) for column in columns.values()]
    if arrays[0].ndim != 1 or any(array.shape != arrays[0].shape for array in arrays):
        shapes = ", ".join(
            f"{name} {array.shape}" for name, array in zip(columns, arrays, strict=True)
        )
        raise ValueError(f"The columns must be one-dimensional and of one length, but are {shapes}")
    stream = io.StringIO()
    stream.write(",".join(columns) + "\n")
    np.savetxt(stream, np.column_stack(arrays), fmt="%.17g", delimiter=",")
    return stream.getvalue()
