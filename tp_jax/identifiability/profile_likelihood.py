"""Profile likelihood: how much worse a fit gets when one parameter is held away from its best.

All other unknowns, the nuisances and the window states among them, are optimised again at each
value. Unlike a standard error the profile follows a likelihood that is not a parabola, and it
says where one end of an interval is open: any value beyond does as well.

The windowed objective treats neighbouring windows as independent, so that the critical level of a
drop of the sum of squares is that of chi-square, times the part by which the scatter of blocks of a
second exceeds what the noise alone would give (`tp_jax.estimation.intervals`), as is usual for
composite likelihoods.

Sources: Raue et al. (2009), Bioinformatics 25, 1923-1929; Venzon, Moolgavkar (1988), Applied
Statistics 37, 87-94; for the level, Chandler, Bate (2007), Biometrika 94, 167-183.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation import variable_projection
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.intervals import covariance
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.normal_equations import covariance_of
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.priors import GaussianPrior
from tp_jax.estimation.schedule import FINELY
from tp_jax.identifiability.copies import TOLERANCE, Fitted, Start, fit_copies
from tp_jax.model.parameters import Parameter

ROUNDS = 8
"""Values tried at most on either side of the best."""

CLOSE = 0.1
"""An end is read off where the root of the drop is so close, relatively, to the critical one: that
root is nearly straight in the parameter."""

BETTER = 0.5
"""A profile's fit that is better than the best by more than this shows that it was none."""

DOUBTFUL = (1.5, 0.5)
"""A fit along a profile is doubted where it rises by more than so many times what a parabola would
and by more than so much in addition: with sharp friction it may have ended in a kink."""

FARTHEST = 3.0
"""A next value lies at most this many times as far from the best as the last."""

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Profile:
    """Profile of one parameter.

    Attributes:
        name, unit: of the parameter.
        best: value of the best fit, without any prior that is a mere guard [SI unit].
        ci95: ends of the 95 % interval [SI unit]; None: open, the data do not close it there.
        values: (m,) values tried, rising, the best among them.
        drops: (m,) by how much the sum of squares is above that of the best fit.
        level: its critical value.
        inflation: by how much the level is above that for noise alone.
    """

    name: str
    unit: str
    best: float
    ci95: tuple[float | None, float | None]
    values: np.ndarray
    drops: np.ndarray
    level: float
    inflation: float

    @property
    def identifiable(self) -> bool:
        """True where both ends are closed: practical identifiability after Raue et al."""
        return None not in self.ci95

    def to_dict(self) -> dict[str, Any]:
        """Returns the profile as plain numbers."""
        return {
            "value": self.best,
            "unit": self.unit,
            "ci95": list(self.ci95),
            "identifiable": self.identifiable,
            "values": self.values.tolist(),
            "drops": self.drops.tolist(),
            "level": self.level,
            "inflation": self.inflation,
        }


@dataclasses.dataclass
class _End:
    """The search for one end of one interval, in the estimation coordinate."""

    index: int
    side: int  # -1: below the best, +1: above
    inside: tuple[float, float]  # coordinate, root of the drop by its critical value
    outside: tuple[float, float] | None = None
    trial: float = 0.0
    done: bool = False
    found: float | None = None
    nearest: Fitted | None = None


def profiles(
    fit: Fit,
    setting: PreparedCampaign,
    names: Sequence[str],
    *,
    progress: Progress | None = None,
) -> tuple[Profile, ...]:
    """Profiles of some parameters, and the 95 % intervals they give; all fits in batches.

    Args:
        fit: the best fit on the windows over which to profile.
        setting: its campaign.
        names: of campaign-wide unknowns of the fit.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        ValueError: a name is not among the unknowns.
    """
    unknowns = fit.unknowns
    places = []
    for n in names:
        if Unknown(n) not in unknowns:
            raise ValueError(f"Argument `names` has {n!r}, which is none of the fit's unknowns.")
        places.append(unknowns.index(Unknown(n)))
    # What only keeps steps finite is no knowledge; what the campaign states is.
    priors = [a for a in fit.priors if a.unknown.name in setting.prior_values]
    levels, inflation = levels_of(fit, setting)
    search = _Search(fit, setting, priors)
    better = search.run(places, levels, progress)
    if better is not None:  # a fit along a profile was better than the best: from there again
        search.start_from(better)
        search.run(places, levels, progress, again=False)
    best, out = search.best, []
    for name, i in zip(names, places, strict=True):
        ends = {e.side: e.found for e in search.ends if e.index == i}
        rows = sorted((x, cost - best.cost) for x, cost in search.tried[i])
        values, drops = (np.array(column) for column in zip(*rows, strict=True))
        out.append(
            Profile(
                name,
                search.specs[i].unit,
                _x(best, unknowns, i),
                (ends[-1], ends[1]),
                values,
                drops,
                float(levels[i]),
                float(inflation[i]),
            )
        )
    return tuple(out)


def levels_of(fit: Fit, setting: PreparedCampaign) -> tuple[np.ndarray, np.ndarray]:
    """Critical drop of each unknown, and the inflation in it, (u,) each."""
    robust, dof = covariance(fit, setting)
    free = ~fit.at_bound
    noise = np.zeros_like(robust)
    noise[np.ix_(free, free)] = fit.normal().part(free).covariance()
    inflation = np.full(len(free), max(fit.chi2_dof, 1.0))
    a, b = np.diag(robust), np.diag(noise)
    known = free & (b > 0.0)
    inflation[known] = np.maximum(a[known] / b[known], 1.0)
    return tails.student_level(0.025, dof) ** 2 * inflation, inflation


def _x(found: Fitted, unknowns: Sequence[Unknown], i: int) -> float:
    return found.values.get(unknowns[i].name, unknowns[i].recording)


class _Search:
    """Search that all ends share: the problem, the best fit, how a profile's fits are begun."""

    def __init__(self, fit: Fit, setting: PreparedCampaign, priors: Sequence[GaussianPrior]):
        # an error of the integration that no search would mind is a good part of a drop
        self.problem = fit.problem.at(FINELY)
        self.unknowns, self.priors = fit.unknowns, priors
        self.bounds = setting.bounds
        self.specs: list[Parameter] = [parameter(fit.problem, u) for u in fit.unknowns]
        self.start_from(fit)

    def start_from(self, near: Fit | Fitted) -> None:
        """The best fit, everything free."""
        everything = np.ones(len(self.unknowns), bool)
        self.best = self._fit([Start(near.values, near.states, everything)])[0]
        self.ends: list[_End] = []
        self.tried: dict[int, list[tuple[float, float]]] = {}

    def run(
        self,
        places: Sequence[int],
        levels: np.ndarray,
        progress: Progress | None,
        again: bool = True,
    ) -> Fitted | None:
        """Looks for both ends of each; returns a fit that is better than the best, or None."""
        best = self.best
        self.ends = [
            _End(i, side, (self.coordinate(best, i), 0.0)) for i in places for side in (-1, 1)
        ]
        self.tried = {i: [(_x(best, self.unknowns, i), best.cost)] for i in places}
        for end in self.ends:
            self.first(end, levels[end.index])
        for turn in range(ROUNDS):
            going = [e for e in self.ends if not e.done]
            if not going:
                break
            for end, found in zip(going, self.fitted(going), strict=True):
                if again and found.cost < best.cost - BETTER:
                    return found
                self.tried[end.index].append((_x(found, self.unknowns, end.index), found.cost))
                self.judge(end, found, levels[end.index])
            if progress is not None:
                progress("likelihood profiles", (turn + 1) / ROUNDS)
        return None

    def _fit(self, starts: Sequence[Start]) -> list[Fitted]:
        return fit_copies(
            self.problem, self.unknowns, starts, bounds=self.bounds, priors=self.priors
        )

    def coordinate(self, found: Fitted, i: int) -> float:
        return float(self.specs[i].to_coordinate(_x(found, self.unknowns, i)))

    def limits(self, i: int) -> tuple[float, float]:
        spec = self.specs[i]
        low, high = self.bounds.get(spec.name, (spec.lower, spec.upper))
        low = np.log(max(low, 1e-300)) if spec.transform == "log" else spec.to_coordinate(low)
        return float(low), float(spec.to_coordinate(high))

    def first(self, end: _End, level: float) -> None:
        """The first value: where a parabola would put the end."""
        spread = np.sqrt(max(covariance_of(self.best.information)[end.index, end.index], 0.0))
        step = np.sqrt(level) * spread
        if self.specs[end.index].transform == "log":
            step = min(step, 1.5)
        self._next(end, end.inside[0] + end.side * max(step, 1e-9))

    def _next(self, end: _End, u: float) -> None:
        low, high = self.limits(end.index)
        end.trial = float(np.clip(u, low, high))
        if end.trial == end.inside[0]:  # it stands at its bound already
            end.done, end.found = True, self._at_bound(end)

    def _at_bound(self, end: _End) -> float | None:
        """A friction may well be zero; any other bound is only where the search stops."""
        value = float(self.specs[end.index].from_coordinate(end.trial))
        return 0.0 if end.side < 0 and value == 0.0 else None

    def fitted(self, ends: Sequence[_End]) -> list[Fitted]:
        """Everything else optimised at the ends' trial values."""
        starts = []
        for end in ends:
            near = end.nearest or self.best
            value = float(self.specs[end.index].from_coordinate(end.trial))
            free = np.ones(len(self.unknowns), bool)
            free[end.index] = False
            starts.append(
                Start(
                    near.values.put([self.unknowns[end.index]], np.array([value])),
                    near.states,
                    free,
                )
            )
        found = self._fit(starts)
        doubted = [k for k, end in enumerate(ends) if self._doubted(end, found[k])]
        for k, other in zip(doubted, self._settled([starts[k] for k in doubted]), strict=True):
            if other.cost < found[k].cost:
                found[k] = other
        return found

    def _settled(self, starts: Sequence[Start]) -> list[Fitted]:
        """Fits one after the other, windows put right after every step: slower, past most kinks."""
        ended = []
        for start in starts:
            unknowns = [u for u, f in zip(self.unknowns, start.free, strict=True) if f]
            found = variable_projection.fit(
                self.problem,
                start.values,
                unknowns,
                start.states,
                bounds=dict(self.bounds),
                priors=[a for a in self.priors if a.unknown in unknowns],
                tolerance=TOLERANCE,
                relative=0.0,
            )
            ended.append(Start(found.values, found.states, start.free))
        return self._fit(ended) if ended else []

    def _doubted(self, end: _End, found: Fitted) -> bool:
        """True where a fit is much worse than a parabola says."""
        spread = np.sqrt(max(covariance_of(self.best.information)[end.index, end.index], 0.0))
        away = (end.trial - self.coordinate(self.best, end.index)) / max(spread, 1e-300)
        times, more = DOUBTFUL
        return not found.cost - self.best.cost <= times * away**2 + more

    def judge(self, end: _End, found: Fitted, level: float) -> None:
        """Decides whether the end is found, or where to look next."""
        root = float(np.sqrt(max(found.cost - self.best.cost, 0.0) / level))
        if not np.isfinite(root):  # could not be integrated so far out
            root = FARTHEST
        low, high = self.limits(end.index)
        centre = self.coordinate(self.best, end.index)
        if abs(root - 1.0) < CLOSE:
            at = float(np.clip(centre + (end.trial - centre) / root, low, high))
            end.done, end.found = True, float(self.specs[end.index].from_coordinate(at))
            return
        if root < 1.0:
            end.inside = (end.trial, root)
            if end.trial in (low, high):
                end.done, end.found = True, self._at_bound(end)
                return
        else:
            end.outside = (end.trial, root)
        if root < FARTHEST:
            end.nearest = found
        if end.outside is None:
            away = (end.trial - centre) * min(1.0 / max(root, 1e-3), FARTHEST)
            self._next(end, centre + away)
            end.found = None if not end.done else end.found
            return
        (a, za), (b, zb) = end.inside, end.outside
        part = np.clip((1.0 - za) / (zb - za), 0.1, 0.9)
        end.trial = a + part * (b - a)
        # should the rounds end here, this is the best that is known
        end.found = float(self.specs[end.index].from_coordinate(end.trial))
