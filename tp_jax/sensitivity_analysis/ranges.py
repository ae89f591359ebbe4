"""Ranges of the parameters over which a global analysis looks."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax.model.parameters import BY_NAME

SPREAD = 1.25
"""Parameters run from a fit's value by this factor down to one by it up."""


@dataclasses.dataclass(frozen=True)
class Range:
    """Values of one parameter.

    Attributes:
        name: of the parameter.
        low, high: ends [SI unit].
        log: whether values are uniform in the logarithm.
    """

    name: str
    low: float
    high: float
    log: bool

    def at(self, u: np.ndarray) -> np.ndarray:
        """Values at places u in [0, 1]."""
        if self.log:
            return self.low * (self.high / self.low) ** u
        return self.low + (self.high - self.low) * u


def ranges(
    values: Mapping[str, float], names: Sequence[str], B1: float, spread: float = SPREAD
) -> tuple[Range, ...]:
    """Ranges about some values.

    A parameter that is zero has no factor to be varied by. It runs from zero to what is typical of
    it, Ts2 to the contact's dry friction, so that its lack of influence is none of its range's.

    Args:
        values: by name, SI units.
        names: of the parameters.
        B1: inertia of the column, to which typical sizes are scaled [kg m^2].
        spread: factor, above 1.

    Raises:
        ValueError: the factor is not above 1.
    """
    if not spread > 1.0:
        raise ValueError(f"Argument `spread` must be above 1, but is {spread:g}.")
    out = []
    for name in names:
        value = abs(values.get(name, 0.0))
        typical = BY_NAME[name].scaled(B1).typical
        if name == "Ts2":
            dry = values.get("Ts1", 0.0) + values.get("Tst", 0.0)
            out.append(Range(name, 0.0, max(value, dry, 1e-3 * typical), False))
        elif value < 1e-3 * typical and BY_NAME[name].transform != "log":
            out.append(Range(name, 0.0, typical, False))
        else:
            sign = 1.0 if values[name] >= 0.0 else -1.0
            ends = sorted((sign * value / spread, sign * value * spread))
            out.append(Range(name, ends[0], ends[1], True))
    return tuple(out)
