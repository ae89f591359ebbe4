"""Each recording fitted alone: are its parameters those of the others?

The paper's own criterion for a valid model (Section 6): the parameters obtained "should be equal
to each other". All parameters together are tested by the sum of squares that one set of numbers
for all recordings costs over one set for each; each parameter by the weighted scatter of its
values.

Sources: Rotnitzky, Jewell (1990), Biometrika 77, 485-497 (the mean inflation of a likelihood ratio
of correlated data); Cochran (1954), Biometrics 10, 101-129 (the scatter).
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import stats

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.least_squares import Fit, parameter
from tp_jax.identifiability.copies import Fitted, Start, fit_copies
from tp_jax.identifiability.information import inverse
from tp_jax.identifiability.profile_likelihood import levels_of
from tp_jax.model.parameters import BASE

LEVEL = 0.05

KNOWN = 1.0
"""Directions in which a recording alone knows relative changes better than this count for it."""

TOLD = 0.5
"""A recording alone tells a parameter where its standard error is below this part of it."""

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Consistency:
    """What `consistency` found.

    Attributes:
        recordings: labels of those fitted alone.
        values: parameter -> recording -> value alone [SI unit], None where it does not tell it.
        standard_errors: likewise.
        common: parameter -> value of the common fit.
        drop: of the sum of squares from one set of numbers to one set each, inflation taken out.
        degrees: of freedom of it.
        p: probability of such a drop if the parameters are equal; None with one recording.
        p_by_parameter: parameter -> that of the scatter of its values, adjusted for their number.
    """

    recordings: tuple[str, ...]
    values: dict[str, dict[str, float | None]]
    standard_errors: dict[str, dict[str, float | None]]
    common: dict[str, float]
    drop: float
    degrees: int
    p: float | None
    p_by_parameter: dict[str, float]

    @property
    def rejected(self) -> bool:
        """Whether the recordings differ in their parameters."""
        return self.p is not None and self.p < LEVEL

    @property
    def differing(self) -> tuple[str, ...]:
        """Parameters that are not the same in all recordings, the clearest first."""
        found = [n for n, p in self.p_by_parameter.items() if p < LEVEL]
        return tuple(sorted(found, key=self.p_by_parameter.__getitem__))

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers."""
        return {**dataclasses.asdict(self), "rejected": self.rejected, "level": LEVEL}


def consistency(fit: Fit, setting: Setting, *, progress: Progress | None = None) -> Consistency:
    """Fits each fitted recording alone, on the windows of a common fit, and compares.

    Args:
        fit: of all of them together.
        setting: its campaign.
        progress: called with a stage's name and the part of it that is done.
    """
    report = progress or (lambda stage, fraction: None)  # noqa: ARG005
    anchors = [a for a in fit.anchors if a.unknown.name in setting.priors]
    everything = np.ones(len(fit.unknowns), bool)

    def alone(recordings: list[int]) -> Fitted:
        problem = setting.problem(fit.problem.windows.horizon, recordings)
        states = fit.states[fit.problem.select(recordings)]
        start = Start(fit.values, states, everything)
        return fit_copies(problem, fit.unknowns, [start], bounds=setting.bounds, anchors=anchors)[0]

    common = alone(setting.fitted)
    found = []
    for i in setting.fitted:
        report("recordings alone", len(found) / len(setting.fitted))
        found.append(alone([i]))
    _, inflation = levels_of(fit, setting)
    scale = _scale(fit)
    ranks = [_rank(f.information, scale) for f in found]
    degrees = max(sum(ranks) - _rank(common.information, scale), 0)
    drop = max(common.cost - sum(f.cost for f in found), 0.0) / float(np.mean(inflation))
    several = len(found) > 1 and degrees > 0
    p = float(stats.chi2.sf(drop, degrees)) if several else None
    labels = tuple(setting.recordings[i].label for i in setting.fitted)
    values, errors, scatter = _by_parameter(fit, found, labels, inflation)
    return Consistency(
        labels, values, errors, {n: common.values.get(n) for n in values}, drop, degrees, p,
        _adjusted(scatter),
    )  # fmt: skip


def _scale(fit: Fit) -> np.ndarray:
    """A relative change of each unknown in its estimation coordinate (u,)."""
    out = []
    for u in fit.unknowns:
        spec = parameter(fit.problem, u)
        if spec.transform == "log":
            out.append(1.0)
            continue
        physical = any(u.name == p.name for p in BASE)
        value = abs(fit.values.get(u.name, u.recording)) / spec.typical
        out.append(max(value, 1e-3) if physical else 1.0)
    return np.array(out)


def _rank(information: np.ndarray, scale: np.ndarray) -> int:
    values = np.linalg.eigvalsh(information * np.outer(scale, scale))
    return int((values > 1.0 / KNOWN**2).sum())


def _by_parameter(
    fit: Fit, found: list[Fitted], labels: tuple[str, ...], inflation: np.ndarray
) -> tuple[dict, dict, dict[str, float]]:
    """Values and standard errors alone, and p of their scatter."""
    names = [p.name for p in BASE]
    values: dict[str, dict] = {}
    errors: dict[str, dict] = {}
    scatter: dict[str, float] = {}
    for j, u in enumerate(fit.unknowns):
        if u.name not in names:
            continue
        spec = parameter(fit.problem, u)
        values[u.name], errors[u.name] = {}, {}
        told = []
        for label, one in zip(labels, found, strict=True):
            x = one.values.get(u.name)
            variance = inverse(one.information)[j, j] * inflation[j]
            sd = float(np.sqrt(max(variance, 0.0))) * spec.slope(x)
            known = one.converged and sd < TOLD * abs(x)
            values[u.name][label] = float(x) if known else None
            errors[u.name][label] = sd if known else None
            if known:
                told.append((x, sd))
        if len(told) > 1:
            x, sd = np.array(told).T
            weight = 1.0 / sd**2
            mean = (weight * x).sum() / weight.sum()
            scatter[u.name] = float(stats.chi2.sf((weight * (x - mean) ** 2).sum(), x.size - 1))
    return values, errors, scatter


def _adjusted(scatter: dict[str, float]) -> dict[str, float]:
    from statsmodels.stats.multitest import multipletests

    if not scatter:
        return {}
    adjusted = multipletests(list(scatter.values()), LEVEL, "holm")[1]
    return {n: float(p) for n, p in zip(scatter, adjusted, strict=True)}
