"""Motions at many points of the parameter space, one experiment after the other."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from tp_jax.identifiability.design import Design
from tp_jax.sensitivity_analysis.ranges import Range
from tp_jax.simulation.sweep import sweep

TOLERANCE = 1e-6  # rad, of a step
LEAST_SPREAD = 1e-9
"""An output that varies by less than this [rad] is the solver's rounding."""


def values_at(
    unit: Float[np.ndarray, "N P"], over: Sequence[Range]
) -> dict[str, Float[np.ndarray, " N"]]:
    """Values of the parameters at places of the unit cube."""
    return {r.name: r.at(unit[:, i]) for i, r in enumerate(over)}


def motions(
    design: Design,
    values: Mapping[str, float],
    varied: Mapping[str, Float[np.ndarray, " N"]],
) -> dict[str, Float[np.ndarray, "N n"]]:
    """Angles of many pendulums in one experiment [rad], by channel.

    Args:
        design: the experiment.
        values: what is the same for all, by name, SI units.
        varied: what is not, (N,) each.

    Raises:
        RuntimeError: a run did not reach its end.
    """
    own = {n: v for n, v in varied.items() if n in design.unknowns}
    found = sweep(
        design.build({**values, **own}),
        design.ts,
        design.y0,
        tolerance=TOLERANCE,
        velocities=False,
    )
    if not found.complete.all():
        lost = int((~found.complete).sum())
        raise RuntimeError(f"{lost} of {found.complete.size} runs did not reach their end.")
    size = next(iter(varied.values())).size
    wide = {"phi1": found.phi1, "phi2": found.phi2}
    return {c: np.broadcast_to(wide[c], (size, design.ts.size)) for c in design.channels}
