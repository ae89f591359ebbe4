"""Derivatives of a motion by relative changes of its numbers: one column each."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from tp_jax.identifiability.design import PLACES, Design
from tp_jax.model.arrays import AnyArray
from tp_jax.simulation.sensitivities import sensitivities
from tp_jax.simulation.solve import Trajectory

TOLERANCE = 1e-7  # rad, of a step


class LogDerivatives(NamedTuple):
    """Derivatives of the two angles by the logarithms of some numbers.

    motion: the run; phi1, phi2: (n, P) [rad per unit of logarithm], the change of an angle where
    a number grows by a small part of itself, by that part; reliable: (P,) and growth: as in
    `Sensitivities`.
    """

    motion: Trajectory
    phi1: Float[np.ndarray, "n P"]
    phi2: Float[np.ndarray, "n P"]
    reliable: Bool[np.ndarray, " P"]
    growth: float | AnyArray

    def weighted(self, sigma: Float[np.ndarray, " 2"]) -> Float[np.ndarray, "m P"]:
        """Rows of both angles in units of their noise; a channel not measured has no rows."""
        rows = [
            d / sd for d, sd in zip((self.phi1, self.phi2), sigma, strict=True) if np.isfinite(sd)
        ]
        return np.concatenate(rows)


def log_derivatives(
    design: Design,
    values: Mapping[str, float],
    names: Sequence[str],
    scale: Mapping[str, float] | None = None,
) -> LogDerivatives:
    """Derivatives along one experiment.

    Args:
        design: the experiment.
        values: numbers by name, SI units.
        names: of those to differentiate by. What the experiment's pendulum does not have (a drive
            amplitude where the drive is measured) has a column of zeros.
        scale: steps by name, SI units, instead of the numbers themselves: a number that is zero
            has no logarithm.
    """
    own = [n for n in names if n in design.unknowns or n == "reaction"]
    found = sensitivities(
        design.build(values),
        design.ts,
        design.y0,
        by=[PLACES[n] for n in own],
        tolerance=TOLERANCE,
    )
    steps = np.array([(scale or {}).get(n, values.get(n, 1.0)) for n in own])
    where = [list(names).index(n) for n in own]
    state = len(design.y0)
    out = []
    for angle in (found.phi1, found.phi2):
        wide = np.zeros((len(design.ts), len(names)))
        wide[:, where] = angle[:, state:] * steps
        out.append(wide)
    reliable = np.ones(len(names), bool)
    reliable[where] = found.reliable[state:]
    return LogDerivatives(found.motion, out[0], out[1], reliable, found.growth)
