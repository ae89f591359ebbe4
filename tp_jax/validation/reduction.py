"""The smallest baseline that is not rejected: friction terms left out, one after the other.

The paper names "too many frictional effects" as a reason for its trouble. Beginning with all of
them, the term whose loss costs least is left out as long as the data do not reject that; the fits
of one round run side by side.

A coefficient at zero lies at its bound, where half of chance's drops are none: the reference is an
even mixture of nothing and chi-square with one degree of freedom. Without Tst, T0 is no parameter;
chi-square with two is then on the safe side.

Sources: Self, Liang (1987), Journal of the American Statistical Association 82, 605-610 (bounds);
Davies (1987), Biometrika 74, 33-43 (a parameter that is there under one hypothesis only).
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy import stats

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.least_squares import Fit
from tp_jax.identifiability.copies import Fitted, Start, fit_copies
from tp_jax.identifiability.profile_likelihood import levels_of

LEVEL = 0.05

#: Term -> parameters that go with it. A term that is gone has its first at zero.
TERMS = {
    "viscous bearing": ("c1",),
    "dry bearing": ("M1",),
    "viscous contact": ("Tv",),
    "rising contact": ("Tst", "T0"),
}

Progress = Callable[[str, float | None], None]


@dataclasses.dataclass(frozen=True)
class Step:
    """One term tried. drop: rise of the sum of squares without it, inflation taken out; p: of such
    a rise by chance; left_out: whether the term is."""

    term: str
    parameters: tuple[str, ...]
    drop: float
    p: float
    left_out: bool


@dataclasses.dataclass(frozen=True)
class Reduction:
    """What `reduction` found.

    Attributes:
        steps: every term tried, round by round.
        without: parameters that the proposed baseline does without.
        free: friction parameters that it keeps.
        values: parameter -> value in the proposed baseline [SI unit].
        chi2_dof: of the proposed baseline, and of the full one.
    """

    steps: tuple[tuple[Step, ...], ...]
    without: tuple[str, ...]
    free: tuple[str, ...]
    values: dict[str, float]
    chi2_dof: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers."""
        return {
            "level": LEVEL,
            "without": list(self.without),
            "free": list(self.free),
            "values": self.values,
            "chi2_dof": {"proposed": self.chi2_dof[0], "full": self.chi2_dof[1]},
            "rounds": [[dataclasses.asdict(s) for s in turn] for turn in self.steps],
        }


def reduction(fit: Fit, setting: Setting, *, progress: Progress | None = None) -> Reduction:
    """Leaves out friction terms of a fit until the data reject it.

    Args:
        fit: with all terms.
        setting: its campaign.
        progress: called with a stage's name and the part of it that is done.
    """
    report = progress or (lambda stage, fraction: None)  # noqa: ARG005
    names = [u.name for u in fit.unknowns]
    left = {term: own for term, own in TERMS.items() if set(own) & set(names)}
    anchors = [a for a in fit.anchors if a.unknown.name in setting.priors]
    inflation = float(np.mean(levels_of(fit, setting)[1]))

    def fitted(starts: Sequence[Start]) -> list[Fitted]:
        return fit_copies(fit.problem, fit.unknowns, starts, bounds=setting.bounds, anchors=anchors)

    everything = np.ones(len(names), bool)
    best = fitted([Start(fit.values, fit.states, everything)])[0]
    full, gone, rounds = best, [], []
    while left:
        report("smaller baselines", len(gone) / len(TERMS))
        starts = [_start(best, own, gone, names) for own in left.values()]
        trials = fitted(starts)
        tried = []
        for (term, own), found in zip(left.items(), trials, strict=True):
            rise = max(found.cost - best.cost, 0.0) / inflation
            tried.append((term, own, rise, _p(rise, own, names), found))
        term, own, _, p, found = max(tried, key=lambda row: row[3])
        accepted = p > LEVEL
        rounds.append(tuple(Step(t, o, d, q, accepted and t == term) for t, o, d, q, _ in tried))
        if not accepted:
            break
        gone += [n for n in own if n in names]
        del left[term]
        best = found
    free = [n for own in TERMS.values() for n in own if n in names and n not in gone]
    chi = tuple(_chi2_dof(fit, f, k) for f, k in ((best, len(gone)), (full, 0)))
    kept = {n: best.values.get(n) for n in names}
    return Reduction(tuple(rounds), tuple(gone), tuple(free), kept, chi)


def _start(best: Fitted, own: Sequence[str], gone: Sequence[str], names: list[str]) -> Start:
    """The best so far without one more term; what it held goes to the contact's constant part."""
    changes = {own[0]: 0.0}
    if own[0] == "Tst":
        changes["Ts1"] = best.values.get("Ts1") + 0.8 * best.values.get("Tst")
    free = np.array([n not in own and n not in gone for n in names])
    values: Values = best.values.put(
        [Unknown(n) for n in changes], np.array(list(changes.values()))
    )
    return Start(values, best.states, free)


def _p(rise: float, own: Sequence[str], names: list[str]) -> float:
    """Probability of such a rise if the term is not there."""
    if not np.isfinite(rise):
        return 0.0
    if len([n for n in own if n in names]) > 1:
        return float(stats.chi2.sf(rise, 2))
    return float(0.5 * stats.chi2.sf(rise, 1)) if rise > 0.0 else 1.0


def _chi2_dof(fit: Fit, found: Fitted, fewer: int) -> float:
    return found.cost / max(fit.dof + fewer, 1)
