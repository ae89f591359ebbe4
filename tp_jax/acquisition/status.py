"""What a recording is at, for whoever shows it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Status:
    """A recording in the making.

    Attributes:
        t: time of the last sample [s].
        duration: wanted [s].
        rate: samples per second of late, on the host's clock; None before it is known.
        written, lost: samples.
        corrupt: frames or lines.
        unplugged: whether the rig is waited for.
        names: of the columns.
        recent: (n, columns) the last samples.
    """

    t: float
    duration: float
    rate: float | None
    written: int
    lost: int
    corrupt: int
    unplugged: bool
    names: tuple[str, ...]
    recent: np.ndarray


Progress = Callable[[Status], None]
