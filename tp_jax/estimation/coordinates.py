"""Coordinates in which unknowns are estimated: logarithms where only a factor makes sense."""

from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax.estimation.bounded_step import LONGEST_LOG
from tp_jax.estimation.layout import Unknown
from tp_jax.model.parameters import Parameter

SMALLEST = 1e-300
"""In place of a zero whose logarithm is asked for."""

Bounds = Mapping[str, tuple[float, float]]


class Coordinates:
    """Coordinates of some unknowns.

    Attributes:
        unknowns: u of them. specs: their parameters.
        limits: (u, 2) bounds [SI units]. ends: (u, 2) the same in coordinates.
    """

    def __init__(
        self, unknowns: Sequence[Unknown], specs: Sequence[Parameter], bounds: Bounds | None = None
    ):
        """Makes them.

        Args:
            unknowns, specs: see the class. bounds: by name, instead of the parameters' own.
        """
        given = bounds or {}
        self.unknowns, self.specs = tuple(unknowns), list(specs)
        limits = [given.get(s.name, (s.lower, s.upper)) for s in self.specs]
        self.limits = np.array(limits, float).reshape(-1, 2)
        self.ends = np.stack([self.of(end) for end in self.limits.T], axis=1)
        self._longest = np.array(
            [LONGEST_LOG if s.transform == "log" else np.inf for s in self.specs]
        )

    def of(self, x: Sequence[float] | np.ndarray) -> np.ndarray:
        """Coordinates (u,) of values [SI units]."""
        return np.array(
            [
                float(s.to_coordinate(max(v, SMALLEST) if s.transform == "log" else v))
                for s, v in zip(self.specs, x, strict=True)
            ]
        )

    def values(self, u: np.ndarray) -> np.ndarray:
        """Values (u,) [SI units] of coordinates, within the limits."""
        x = [float(s.from_coordinate(v)) for s, v in zip(self.specs, u, strict=True)]
        return np.clip(np.array(x, float), *self.limits.T)

    def slope(self, x: Sequence[float] | np.ndarray) -> np.ndarray:
        """Derivatives (u,) of the values by their coordinates."""
        return np.array([s.slope(v) for s, v in zip(self.specs, x, strict=True)], float)

    def box(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds (u,) of a step from coordinates u: no logarithm goes further than its derivative
        reaches."""
        low, high = self.ends.T
        return np.maximum(low - u, -self._longest), np.minimum(high - u, self._longest)
