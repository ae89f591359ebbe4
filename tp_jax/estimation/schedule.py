"""The horizons of a fit, from windows that are short and few to all of them at full length.

Short windows are convex enough to be found from afar; long ones say more. The first rung takes
only some of the windows, spread over all recordings: that is enough to get near, at a tenth of
the cost. The friction's smoothing is raised with the horizon, and once more at the end.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from tp_jax.estimation.baseline import warm_start_states
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss, robust
from tp_jax.estimation.sharpen import FINELY
from tp_jax.estimation.variable_projection import fit as fit_projected
from tp_jax.estimation.window_states import in_turn, of_windows, settle
from tp_jax.model.parameters import PAPER_EPS

FEW = 64  # windows of the first rung
ROUGH = 1e-4  # a horizon that is left again need not be finished to more than this part
FINE = 1e-6

#: Fits unknowns and window states: see `variable_projection.fit`.
Method = Callable[..., Fit]
Objective = Literal["windows", "free-run"]


@dataclasses.dataclass(frozen=True)
class Rung:
    """horizon [s]; eps: smoothing of the friction [s]; few: whether only some windows are used;
    relative: part of the sum of squares that is not worth a step."""

    horizon: float
    eps: float
    few: bool
    relative: float


def rungs(setting: PreparedCampaign, objective: Objective = "windows") -> tuple[Rung, ...]:
    """Returns the rungs from the shortest horizon of a campaign to the longest, for a free run the
    longest alone; the last one again with the sharpest friction."""
    if objective == "free-run":
        longest = max(setting.recordings[i].duration for i in setting.fitted)
        return _with_sharpest(setting, Rung(longest, setting.eps, False, FINE))
    short, middle, long = setting.horizons
    first = min(PAPER_EPS, setting.eps)
    return _with_sharpest(
        setting,
        Rung(short, first, True, ROUGH),
        Rung(middle, float(np.sqrt(first * setting.eps)), False, ROUGH),
        Rung(long, setting.eps, False, FINE),
    )


def _with_sharpest(setting: PreparedCampaign, *below: Rung) -> tuple[Rung, ...]:
    """Rungs and, where the friction can be sharper yet (see `sharpen`), the last one so."""
    if setting.sharpest <= below[-1].eps:
        return below
    return (*below, dataclasses.replace(below[-1], eps=setting.sharpest))


def problem_of(setting: PreparedCampaign, rung: Rung) -> Problem:
    """The windows of a rung."""
    problem = setting.problem(rung.horizon)
    if rung.eps > setting.eps:
        problem = problem.at(FINELY)
    n = problem.windows.n
    if not rung.few or n <= FEW:
        return problem
    which = np.unique(np.linspace(0, n - 1, FEW).round().astype(int))
    return of_windows(problem, in_turn(problem.windows, which))


class Schedule:
    """The rungs of a campaign with a method to fit at each."""

    def __init__(
        self,
        setting: PreparedCampaign,
        method: Method = fit_projected,
        *,
        objective: Objective = "windows",
        loss: Loss = "linear",
    ):
        self.setting = setting
        self.method = method
        self.objective: Objective = objective
        self.loss: Loss = loss
        self.rungs = rungs(setting, objective)

    def of(self, setting: PreparedCampaign) -> "Schedule":
        """The same for another setting."""
        return Schedule(setting, self.method, objective=self.objective, loss=self.loss)

    def first(self, values: Values) -> Fit:
        """The first rung, from any numbers."""
        return self._fit(self.rungs[0], values, None)

    def run(self, values: Values) -> Fit:
        """The rungs above the first (it again where there is but one); evaluations are of all."""
        fit, passes = None, 0
        for rung in self.rungs[1:] or self.rungs:
            fit = self._fit(rung, values if fit is None else fit.values, fit)
            passes += fit.evaluations
        assert fit is not None
        fit.evaluations = passes
        return fit

    def refine(self, fit: Fit) -> Fit:
        """The last rung again, from where a fit of it ended."""
        return self._fit(self.rungs[-1], fit.values, None, fit.states)

    def as_it_is(self, values: Values, states: np.ndarray | None = None) -> Fit:
        """Evaluates numbers at the last rung: only the windows' states are fitted, and not even
        they where they are given."""
        problem = problem_of(self.setting, self.rungs[-1])
        values = self._smoothed(self.rungs[-1], values)
        unknowns, passes = self.setting.unknowns(), 0.0
        if states is None:
            states = problem.initial_states(values)
            lin = robust(problem.linearise(values, states, ()), self.loss)
            found = settle(problem, values, states, lin, (), loss=self.loss)
            states, passes = found.states, 1.0 + found.passes
        fit = fit_projected(
            problem,
            values,
            unknowns,
            states,
            bounds=self.setting.bounds,
            priors=self.setting.priors(),
            max_iterations=0,
            loss=self.loss,
        )
        fit.evaluations = int(np.ceil(fit.evaluations + passes))
        return fit

    def coordinates(self, x: Sequence[float] | np.ndarray) -> np.ndarray:
        """Estimation coordinates (u,) of the unknowns."""
        unknowns = self.setting.unknowns()
        specs = [parameter(self._any, u) for u in unknowns]
        return np.array([float(s.to_coordinate(v)) for s, v in zip(specs, x, strict=True)])

    @property
    def _any(self) -> Problem:
        """A problem, to ask for the unknowns' parameters."""
        return self.setting.problem(self.rungs[-1].horizon)

    def _fit(
        self, rung: Rung, values: Values, before: Fit | None, states: np.ndarray | None = None
    ) -> Fit:
        problem = problem_of(self.setting, rung)
        if before is not None:
            states = warm_start_states(before, problem)
        return self.method(
            problem,
            self._smoothed(rung, values),
            self.setting.unknowns(),
            states,
            bounds=self.setting.bounds,
            priors=self.setting.priors(),
            relative=rung.relative,
            loss=self.loss,
        )

    @staticmethod
    def _smoothed(rung: Rung, values: Values) -> Values:
        return values.replace({"eps1": rung.eps, "eps2": rung.eps})
