"""Scale of the computations."""

from typing import NamedTuple

import numpy as np


class Scale(NamedTuple):
    """duration [s], rate [Hz] of the runs; iterations of the searches; points of the rank."""

    duration: float = 10.0
    rate: float = 100.0
    listing: int = 50
    thousands: int = 2000
    gradients: int = 200
    points: int = 12
    seed: int = 0

    @property
    def ts(self) -> np.ndarray:
        """Times of the runs of Section 5.1 (n,) [s]."""
        return np.arange(round(self.duration * self.rate) + 1) / self.rate


QUICK = Scale(duration=4.0, rate=50.0, listing=5, thousands=30, gradients=10, points=2)
