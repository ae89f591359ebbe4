"""NumPy's own files, .npy and .npz; nothing pickled is loaded."""

from pathlib import Path

import numpy as np

from tp_jax.recordings.readers.matrices import columns


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:  # noqa: ARG001
    """The arrays by name; of a single one the columns, and those of a structured one by name."""
    content = np.load(file, allow_pickle=False)
    if isinstance(content, np.ndarray):
        if content.dtype.names:
            return columns((name, content[name]) for name in content.dtype.names)
        return columns([("array", content)])
    with content:
        return columns((name, content[name]) for name in content.files)
