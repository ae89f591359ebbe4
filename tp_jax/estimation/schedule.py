"""The one schedule of a fit: window lengths that grow, friction that sharpens with them.

Short windows are convex enough to be found from afar; long ones say more. A rung that is left
again takes only some of the windows, spread over all recordings, and is not finished: that is
enough to get near, at a tenth of the cost. Diagnosis, identification and sensitivity analysis
climb the same rungs.
"""

import dataclasses
import logging
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.from_readings import fit_from_readings
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.robust import Loss
from tp_jax.estimation.slow_contact import with_slow_contact
from tp_jax.estimation.variable_projection import fit as fit_projected
from tp_jax.estimation.window_states import in_turn, of_windows, warm_start_states
from tp_jax.model.parameters import PAPER_EPS
from tp_jax.simulation.lanes import Tolerances

log = logging.getLogger(__name__)

PATIENCE = 100  # steps of a fit: far from a rider that hardly moves, some rigs need more than 50

MOST_WINDOWS = 160
"""Windows of a rung that only leads to the next one: more say no better which valley it is."""

MOST_OF_MANY_STARTS = 64
"""The same where many starts climb: most of them are left behind after the first rung."""

ROUGH = 1e-4  # of a rung that is left again; at 1e-3 starts end so far apart that few meet
FINE = 1e-7

FINELY = Tolerances(angle=1e-7, friction=0.1)
"""Of the integration at a rung with the sharpest friction: see `sharpen`."""

#: Fits unknowns and window states: see `variable_projection.fit`.
Method = Callable[..., Fit]
Objective = Literal["windows", "free-run"]
Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Rung:
    """horizon [s]; eps: smoothing of the friction [s]; most: windows it uses, None for all;
    relative: part of the sum of squares that is not worth a step; tolerances: of the integration,
    None for the campaign's."""

    horizon: float
    eps: float
    most: int | None
    relative: float
    tolerances: Tolerances | None = None


def rungs(
    setting: PreparedCampaign,
    objective: Objective = "windows",
    *,
    horizons: Sequence[float] | None = None,
    sharp: bool = True,
    first: int = MOST_WINDOWS,
) -> tuple[Rung, ...]:
    """The rungs from the shortest horizon of a campaign to the longest.

    Args:
        setting: the campaign.
        objective: for a "free-run" there is the longest horizon alone, that of whole recordings.
        horizons: window lengths [s], growing; the campaign's own if None.
        sharp: whether the last one comes again with the sharpest friction, in two steps, where the
            friction can be sharper than that of the search (see `sharpen`).
        first: windows of the first rung.
    """
    if objective == "free-run":
        horizons = [max(setting.recordings[i].duration for i in setting.fitted)]
    elif horizons is None:
        horizons = setting.horizons
    *below, last = horizons
    eps = np.minimum(np.geomspace(PAPER_EPS, setting.eps, max(len(below), 1)), setting.eps)
    found = [
        Rung(h, float(eps[i]), MOST_WINDOWS if i else first, ROUGH) for i, h in enumerate(below)
    ]
    found.append(Rung(last, setting.eps, None, FINE))
    if sharp and setting.sharpest > setting.eps:
        between = halfway(setting.eps, setting.sharpest)
        found.append(Rung(last, between, None, ROUGH, FINELY))
        found.append(Rung(last, setting.sharpest, None, FINE, FINELY))
    return tuple(found)


def halfway(eps: float, sharper: float) -> float:
    """Smoothing of the friction [s] at which a fit stops on its way to the sharpest."""
    return float(np.sqrt(eps * sharper))


def problem_of(setting: PreparedCampaign, rung: Rung) -> Problem:
    """The windows of a rung."""
    problem = setting.problem(rung.horizon)
    if rung.tolerances is not None:
        problem = problem.at(rung.tolerances)
    return problem if rung.most is None else thinned(problem, rung.most)


def thinned(problem: Problem, most: int = MOST_WINDOWS) -> Problem:
    """The problem of at most so many of its windows, spread over all recordings."""
    n = problem.windows.n
    if n <= most:
        return problem
    return of_windows(problem, in_turn(problem.windows, few_of(n, most)))


def few_of(count: int, most: int = MOST_WINDOWS) -> np.ndarray:
    """Places of at most so many of `count` windows, spread over all, at no regular distance.

    Every second one of windows of a quarter of a period would always see the same of the swing.
    """
    if count <= most:
        return np.arange(count)
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    within = (np.arange(most) * golden) % 1.0
    edges = np.arange(most + 1) * count // most
    return edges[:-1] + (within * np.diff(edges)).astype(int)


def fit_over_schedule(
    setting: PreparedCampaign,
    values: Values,
    unknowns: Sequence[Unknown],
    *,
    horizons: Sequence[float] | None = None,
    progress: Progress | None = None,
    max_iterations: int = PATIENCE,
) -> Fit:
    """Fits with the friction of a search, whose sharpest is `sharpen`'s.

    Args:
        setting: the campaign.
        values: where it begins, and everything that is not fitted.
        unknowns: what to fit.
        horizons: window lengths [s], growing; the campaign's own if None.
        progress: called with a stage's name and the part of it that is done.
        max_iterations: at each rung; see `variable_projection.fit`.
    """
    climbed = rungs(setting, horizons=horizons, sharp=False)
    schedule = Schedule(setting, unknowns=unknowns, climbed=climbed, max_iterations=max_iterations)
    return schedule.run(values, whole=True, progress=progress)


def refitted(
    setting: PreparedCampaign,
    before: Fit,
    bounds: dict[str, tuple[float, float]] | None = None,
    kinks: bool = False,
) -> Fit:
    """A fit of the same windows and unknowns under another noise, or with other drives.

    Args:
        setting: the campaign, with these. before: where it begins. bounds: those of the campaign
            if None. kinks: see `variable_projection.fit`.
    """
    return fit_projected(
        setting.problem(before.problem.windows.horizon).at(before.problem.tolerances),
        before.values,
        before.unknowns,
        before.states,
        bounds=setting.bounds if bounds is None else bounds,
        priors=before.priors,
        relative=1e-7,
        kinks=kinks,
    )


class Schedule:
    """The rungs of a campaign with a method to fit at each.

    Args:
        setting: the campaign.
        method: fits at each rung.
        objective: see `rungs`.
        loss: of a residual, see `robust`.
        unknowns: what to fit; all that the setting has if None.
        climbed: rungs; if None, those of many starts, up to the sharpest friction.
        max_iterations: at each rung; the method's own number if None.
    """

    def __init__(
        self,
        setting: PreparedCampaign,
        method: Method = fit_projected,
        *,
        objective: Objective = "windows",
        loss: Loss = "linear",
        unknowns: Sequence[Unknown] | None = None,
        climbed: Sequence[Rung] | None = None,
        max_iterations: int | None = None,
    ):
        self.setting = setting
        self.method = method
        self.objective: Objective = objective
        self.loss: Loss = loss
        self.unknowns = tuple(setting.unknowns() if unknowns is None else unknowns)
        if climbed is None:
            climbed = rungs(setting, objective, first=MOST_OF_MANY_STARTS)
        self.rungs = tuple(climbed)
        self.max_iterations = max_iterations

    def of(self, setting: PreparedCampaign) -> "Schedule":
        """The same for another noise, by which the sharpest friction is another too."""
        return Schedule(
            setting,
            self.method,
            objective=self.objective,
            loss=self.loss,
            unknowns=self.unknowns,
            max_iterations=self.max_iterations,
        )

    def first(self, values: Values) -> Fit:
        """The first rung, from any numbers."""
        return self._fit(self.rungs[0], values)

    def run(self, values: Values, *, whole: bool = False, progress: Progress | None = None) -> Fit:
        """The rungs above the first (it again where there is but one); evaluations are of all.

        Args:
            values: where it begins.
            whole: whether the first rung is climbed too.
            progress: called with a stage's name and the part of it that is done.
        """
        climbed = self.rungs if whole else self.rungs[1:] or self.rungs
        found: Fit | None = None
        passes = 0
        for i, rung in enumerate(climbed):
            if progress is not None:
                stage = f"fitting windows: {rung.horizon:.2g} s, {i + 1} of {len(climbed)}"
                progress(stage, i / len(climbed))
            found = self._fit(rung, values, found)
            values, passes = found.values, passes + found.evaluations
            log.info(
                "windows of %.3g s: chi2/dof %.4g, %s", rung.horizon, found.chi2_dof, found.message
            )
        assert found is not None
        found.evaluations = passes
        return found

    def refine(self, fit: Fit) -> Fit:
        """The last rung again, from where a fit of it ended."""
        return self._fit(self.rungs[-1], fit.values, states=fit.states)

    def as_it_is(self, values: Values, states: np.ndarray | None = None) -> Fit:
        """Evaluates numbers at the last rung: only the windows' states are fitted, and not even
        they where they are given."""
        problem = problem_of(self.setting, self.rungs[-1])
        values = _smoothed(self.rungs[-1], values)
        passes = 0.0
        if states is None:
            found = fit_from_readings(problem, values, eps=self.setting.eps, loss=self.loss)
            states, passes = found.states, float(found.evaluations)
        how = self._how(self.rungs[-1]) | {"max_iterations": 0}
        fit = fit_projected(problem, values, self.unknowns, states, **how)
        fit.evaluations = int(np.ceil(fit.evaluations + passes))
        return fit

    def coordinates(self, x: Sequence[float] | np.ndarray) -> np.ndarray:
        """Estimation coordinates (u,) of the unknowns."""
        problem = self.setting.problem(self.rungs[-1].horizon)
        specs = [parameter(problem, u) for u in self.unknowns]
        return np.array([float(s.to_coordinate(v)) for s, v in zip(specs, x, strict=True)])

    def _fit(
        self,
        rung: Rung,
        values: Values,
        before: Fit | None = None,
        states: np.ndarray | None = None,
    ) -> Fit:
        problem = problem_of(self.setting, rung)
        if before is not None:
            states = warm_start_states(before, problem)
        how = self._how(rung)
        found = self.method(problem, _smoothed(rung, values), self.unknowns, states, **how)
        if rung.most is None and rung.tolerances is None and self.objective == "windows":
            found = with_slow_contact(self.setting, found, self.method, how)
        return found

    def _how(self, rung: Rung) -> dict[str, Any]:
        """Options of the method at a rung."""
        patience = {} if self.max_iterations is None else {"max_iterations": self.max_iterations}
        return {
            "bounds": self.setting.bounds,
            "priors": [a for a in self.setting.priors() if a.unknown in self.unknowns],
            "relative": rung.relative,
            "loss": self.loss,
            **patience,
        }


def _smoothed(rung: Rung, values: Values) -> Values:
    return values.replace({"eps1": rung.eps, "eps2": rung.eps})
