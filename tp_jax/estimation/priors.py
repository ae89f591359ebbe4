"""Gaussian priors on unknowns: their part of a sum of squares."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.layout import Unknown


@dataclasses.dataclass(frozen=True)
class GaussianPrior:
    """A prior on one unknown in its estimation coordinate: mean and standard deviation."""

    unknown: Unknown
    mean: float
    sd: float


def prior_cost(
    priors: Sequence[GaussianPrior], unknowns: Sequence[Unknown], u: np.ndarray
) -> float:
    """Sum of squares of the priors.

    Args:
        priors: on some of the unknowns. unknowns: u of them. u: (u,) their coordinates.
    """
    place = list(unknowns).index
    return sum(float((u[place(a.unknown)] - a.mean) / a.sd) ** 2 for a in priors)


def prior_terms(
    priors: Sequence[GaussianPrior], unknowns: Sequence[Unknown], u: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Half the gradient (u,) of the priors' sum of squares, and their information (u,).

    Args:
        priors: on any unknowns. unknowns: u of them. u: (u,) their coordinates.
    """
    pull, information = np.zeros(len(unknowns)), np.zeros(len(unknowns))
    place = {unknown: i for i, unknown in enumerate(unknowns)}
    for a in priors:
        i = place.get(a.unknown)
        if i is not None:
            pull[i] += (u[i] - a.mean) / a.sd**2
            information[i] += 1.0 / a.sd**2
    return pull, information
