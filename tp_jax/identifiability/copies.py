"""Many fits of one problem side by side: copies that differ in their numbers and in what is free.

A lane of the engine has numbers of its own, so that copies are nothing but more windows: all are
linearised in one call, then each takes its own damped Gauss-Newton step. Profiles and nested
models are fitted so, from a fit that is already near.
"""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax.estimation.coordinates import Coordinates
from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import parameter
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import Linearisation, columns
from tp_jax.estimation.priors import GaussianPrior, prior_cost, prior_terms
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.window_states import MAX_STATE_STEP
from tp_jax.estimation.windows import Windows

AT_ONCE = 8
"""Copies linearised together: enough to fill lanes, few enough to fit the memory."""

TOLERANCE = 0.005
"""A copy has converged where its next step promises a smaller drop of the sum of squares."""

MAX_ITERATIONS = 25


@dataclasses.dataclass(frozen=True)
class Start:
    """Start of a copy: its numbers, its window states (w, 4), which unknowns are free (u,)."""

    values: Values
    states: np.ndarray
    free: np.ndarray


@dataclasses.dataclass(frozen=True)
class Fitted:
    """End of a copy: numbers, window states (w, 4), sum of squares with priors, its own
    information matrix (u, u) in estimation coordinates, and whether it converged."""

    values: Values
    states: np.ndarray
    cost: float
    information: np.ndarray
    converged: bool


@dataclasses.dataclass
class _Copy:
    x: np.ndarray  # unknowns, SI units
    values: Values
    states: np.ndarray
    free: np.ndarray
    lin: Linearisation
    cost: float
    damping: float = 1e-6
    done: bool = False
    converged: bool = False
    trial: tuple = ()


def fit_copies(
    problem: Problem,
    unknowns: Sequence[Unknown],
    starts: Sequence[Start],
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Sequence[GaussianPrior] = (),
    tolerance: float = TOLERANCE,
    max_iterations: int = MAX_ITERATIONS,
) -> list[Fitted]:
    """Fits every copy's free unknowns and window states.

    Args:
        problem: recordings in windows.
        unknowns: all that is free in any copy.
        starts: one per copy.
        bounds: by name, instead of the parameters' own.
        priors: the same for all.
        tolerance: see `TOLERANCE`.
        max_iterations: linearisations at most.
    """
    out: list[Fitted] = []
    for i in range(0, len(starts), AT_ONCE):
        group = starts[i : i + AT_ONCE]
        out += _Group(problem, tuple(unknowns), bounds or {}, tuple(priors)).fit(
            group, tolerance, max_iterations
        )
    return out


class _Group:
    """A few copies that are linearised together."""

    def __init__(self, problem, unknowns, bounds, priors):
        self.problem, self.unknowns, self.priors = problem, unknowns, priors
        specs = [parameter(problem, u) for u in unknowns]
        self.space = Coordinates(unknowns, specs, bounds)
        self.slots = columns(unknowns)
        self.wide: dict[int, Problem] = {}

    def fit(self, starts: Sequence[Start], tolerance: float, most: int) -> list[Fitted]:
        xs = [np.clip(s.values.pick(self.unknowns), *self.space.limits.T) for s in starts]
        first = [s.values.put(self.unknowns, x) for s, x in zip(starts, xs, strict=True)]
        lins = self._linearise(first, [s.states for s in starts])
        copies = [
            _Copy(x, v, s.states, s.free, lin, self._cost(v, lin))
            for x, v, s, lin in zip(xs, first, starts, lins, strict=True)
        ]
        for _ in range(most):
            going = []
            for c in copies:
                if not c.done:
                    self._propose(c, tolerance)
                if not c.done:
                    going.append(c)
            if not going:
                break
            lins = self._linearise([c.trial[1] for c in going], [c.trial[2] for c in going])
            for c, lin in zip(going, lins, strict=True):
                self._judge(c, lin)
        return [self._ended(c) for c in copies]

    def _linearise(self, values: Sequence[Values], states: Sequence[np.ndarray]):
        """One call for all, then each copy's own part of it."""
        count, w = len(values), self.problem.windows
        if count not in self.wide:
            self.wide[count] = _repeated(self.problem, count)
        table = np.concatenate([v.table for v in values], axis=1)
        lin = self.wide[count].linearise(
            Values(values[0].layout, table), np.concatenate(states), self.slots
        )
        parts = []
        for k in range(count):
            s = slice(k * w.n, (k + 1) * w.n)
            parts.append(
                Linearisation(
                    lin.r[s],
                    lin.states_jac[s],
                    lin.slots_jac[s],
                    lin.valid[s],
                    lin.states[s],
                    lin.complete[s],
                    lin.slots,
                    w.recording,
                )
            )
        return parts

    def _cost(self, values: Values, lin: Linearisation) -> float:
        return lin.cost() + prior_cost(
            self.priors, self.unknowns, self.space.of(values.pick(self.unknowns))
        )

    def _normal(self, c: _Copy, damping: float):
        """Gradient, information and window states, in estimation coordinates."""
        slope = self.space.slope(c.x)
        elim = eliminated(c.lin, self.unknowns, slope, damping=damping)
        return elim.summed(*prior_terms(self.priors, self.unknowns, self.space.of(c.x))), elim

    def _propose(self, c: _Copy, tolerance: float) -> None:
        if not np.isfinite(c.cost):
            c.done = True
            return
        normal, elim = self._normal(c, c.damping)
        u = self.space.of(c.x)
        low, high = self.space.box(u)
        du = np.zeros(len(u))
        f = c.free
        step = normal.part(f).step(low[f], high[f], c.damping)
        du[f] = step.du
        promise = step.promise + float(((c.lin.r**2).sum(axis=1) - elim.cost).sum())
        if promise < tolerance:
            c.done = c.converged = True
            return
        states = np.clip(elim.state_step, -MAX_STATE_STEP, MAX_STATE_STEP)
        states = c.states + states + elim.following(du) - elim.state_step
        x = np.where(f, self.space.values(u + du), c.x)  # what is held keeps its digits
        c.trial = (x, c.values.put(self.unknowns, x), states, promise)

    def _judge(self, c: _Copy, lin: Linearisation) -> None:
        x, values, states, promise = c.trial
        cost = self._cost(values, lin)
        if cost < c.cost:
            gain = (c.cost - cost) / promise
            c.x, c.values, c.states, c.lin, c.cost = x, values, states, lin, cost
            c.damping = max(c.damping * (0.1 if gain > 0.7 else 0.5 if gain > 0.3 else 3.0), 1e-9)
        else:
            c.damping = max(c.damping, 1e-4) * 8.0
            # no direction improves it: the derivative of a kink, not of the sum of squares
            c.done = c.converged = c.damping > 1e6

    def _ended(self, c: _Copy) -> Fitted:
        information = np.zeros((len(self.unknowns),) * 2)
        if np.isfinite(c.cost):
            information = self._normal(c, 0.0)[0].information
        return Fitted(c.values, c.states, c.cost, information, c.converged)


def _repeated(problem: Problem, count: int) -> Problem:
    """The same recordings and windows `count` times."""
    w, n = problem.windows, len(problem.prepared)
    recording = np.concatenate([w.recording + k * n for k in range(count)])
    windows = Windows(recording, np.tile(w.first, count), np.tile(w.count, count), w.horizon)
    return dataclasses.replace(problem, prepared=problem.prepared * count, windows=windows)
