"""Sensitivity through time: derivatives of the angles along a run, over the noise."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from tp_jax.identifiability.design import Design
from tp_jax.identifiability.log_derivatives import log_derivatives
from tp_jax.model.arrays import AnyArray


class Local(NamedTuple):
    """Local sensitivity through time in one experiment.

    label: of the experiment; names: (P,); t: (n,) s; effect: channel -> (n, P) change of the angle
    [rad] where a parameter changes by a part of itself, per that part (so that 0.01 of it is the
    change for one per cent); rms: channel -> (P,) root of its mean square over the run [rad];
    reliable: (P,) False where the run grazes a reversal or amplifies disturbances so much that a
    finite change does something else; growth: of a disturbance of the start, its largest factor.
    """

    label: str
    names: tuple[str, ...]
    t: Float[np.ndarray, " n"]
    effect: dict[str, Float[np.ndarray, "n P"]]
    rms: dict[str, Float[np.ndarray, " P"]]
    reliable: Bool[np.ndarray, " P"]
    growth: float | AnyArray


def local(
    design: Design, values: Mapping[str, float], names: Sequence[str], scale: Mapping[str, float]
) -> Local:
    """Local sensitivity of one experiment.

    Args:
        design: the experiment.
        values: where the derivatives are taken, by name, SI units.
        names: parameters.
        scale: unit of change by name [SI]: the value itself, or a typical size where it is zero.
    """
    found = log_derivatives(design, values, names, scale)
    both = {"phi1": found.phi1, "phi2": found.phi2}
    effect = {c: both[c] for c in design.channels}
    rms = {c: np.sqrt((e**2).mean(axis=0)) for c, e in effect.items()}
    return Local(design.label, tuple(names), design.ts, effect, rms, found.reliable, found.growth)
