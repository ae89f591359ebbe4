"""End of a fit, and the priors that it had."""

import dataclasses

import numpy as np

from tp_jax.estimation.elimination import Eliminated
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.problem import Problem
from tp_jax.model.parameters import Parameter


@dataclasses.dataclass(frozen=True)
class GaussianPrior:
    """A prior on one unknown in its estimation coordinate: mean and standard deviation."""

    unknown: Unknown
    mean: float
    sd: float


@dataclasses.dataclass
class Fit:
    """End of a fit.

    values: all numbers; states: (w, 4); unknowns; cost: sum of squares, priors included;
    eliminated: gradient and information in *physical* units of the unknowns; at_bound: (u,)
    bool; converged; evaluations: linearisations spent; message: one sentence.
    """

    problem: Problem
    values: Values
    states: np.ndarray
    unknowns: tuple[Unknown, ...]
    cost: float
    eliminated: Eliminated
    linearisation: Linearisation
    at_bound: np.ndarray
    converged: bool
    evaluations: int
    message: str
    priors: tuple[GaussianPrior, ...] = ()

    @property
    def dof(self) -> int:
        """Samples less what was estimated."""
        return self.problem.degrees_of_freedom(len(self.unknowns))

    @property
    def chi2_dof(self) -> float:
        """Sum of squares of the samples' residuals in noise units, by degrees of freedom."""
        return float((self.linearisation.r[:, :-4] ** 2).sum()) / max(self.dof, 1)

    def information(self) -> np.ndarray:
        """H (u, u) in physical units, priors of the unknowns included."""
        H = self.eliminated.H.sum(axis=0)
        for a in self.priors:
            i = self.unknowns.index(a.unknown)
            spec = parameter(self.problem, a.unknown)
            slope = spec.slope(self.values.get(a.unknown.name, a.unknown.recording))
            H[i, i] += 1.0 / (a.sd * slope) ** 2
        return H


def parameter(problem: Problem, unknown: Unknown) -> Parameter:
    """Specification of an unknown's slot, scaled to the rig."""
    return problem.layout.parameters[problem.layout.index[unknown.name]].scaled(problem.B1)
