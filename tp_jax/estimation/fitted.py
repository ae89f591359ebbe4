"""End of a fit."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.coordinates import Coordinates
from tp_jax.estimation.elimination import Eliminated, eliminated
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.normal_equations import NormalEquations
from tp_jax.estimation.priors import GaussianPrior, prior_terms
from tp_jax.estimation.problem import Problem
from tp_jax.model.parameters import Parameter


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

    @classmethod
    def ended(
        cls,
        problem: Problem,
        values: Values,
        states: np.ndarray,
        lin: Linearisation,
        priors: Sequence[GaussianPrior],
        at: Coordinates,
        *,
        cost: float,
        converged: bool,
        evaluations: float,
        message: str,
        near: np.ndarray | float = 0.0,
    ) -> "Fit":
        """Makes the end of a fit from its last linearisation.

        Args:
            problem, values, states, cost, converged, evaluations, message: see the class.
            lin: at these numbers.
            priors: that the fit had.
            at: coordinates of the unknowns, with their limits.
            near: (u,) distance [SI units] from a limit that counts as none.
        """
        x = values.pick(at.unknowns)
        elim = eliminated(lin, at.unknowns)
        at_bound = (x <= at.limits[:, 0] + near) | (x >= at.limits[:, 1] - near)
        return cls(
            problem,
            values,
            states,
            at.unknowns,
            cost,
            elim,
            lin,
            at_bound,
            converged,
            math.ceil(evaluations),
            message,
            tuple(priors),
        )

    @property
    def dof(self) -> int:
        """Samples less what was estimated."""
        return self.problem.degrees_of_freedom(len(self.unknowns))

    @property
    def chi2_dof(self) -> float:
        """Sum of squares of the samples' residuals in noise units, by degrees of freedom."""
        return float((self.linearisation.r[:, :-4] ** 2).sum()) / max(self.dof, 1)

    def normal(self, priors: Sequence[GaussianPrior] | None = None) -> NormalEquations:
        """Returns the normal equations in physical units.

        Args:
            priors: that count; all of the fit's if None.
        """
        priors = self.priors if priors is None else priors
        u, slope = np.zeros(len(self.unknowns)), np.ones(len(self.unknowns))
        for i in (self.unknowns.index(a.unknown) for a in priors):
            spec = parameter(self.problem, self.unknowns[i])
            value = self.values.get(self.unknowns[i].name, self.unknowns[i].recording)
            u[i], slope[i] = float(spec.to_coordinate(value)), spec.slope(value)
        pull, known = prior_terms(priors, self.unknowns, u)
        return self.eliminated.summed(pull / slope, known / slope**2)

    def information(self) -> np.ndarray:
        """H (u, u) in physical units, priors of the unknowns included."""
        return self.normal().information


def parameter(problem: Problem, unknown: Unknown) -> Parameter:
    """Specification of an unknown's slot, scaled to the rig."""
    return problem.layout.parameters[problem.layout.index[unknown.name]].scaled(problem.B1)
