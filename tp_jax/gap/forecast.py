"""Forecasts of runs: how far they swing, and how well they tell the first cause from its rivals.

The first cause is taken for true, as large as it was fitted, and its motion on a run is followed.
A rival then has to explain that motion: windows are cut as for a fit, their states and the rival's
numbers are optimised anew, and what all recordings so far tell of the numbers counts as a prior.
Half of the sum of squares that is left, over the misfit of the first cause's model, is the expected
difference of the log evidences on the run, but for the charge for unknowns, which does not grow
with the run.

Where an effect was refitted its own fit is used, else what the screen predicts for it.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tp_jax.errors import InputError
from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.linearisation import columns
from tp_jax.estimation.normal_equations import efficient_inverse, projected
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.choice import Choice
from tp_jax.gap.diagnosis import Examination
from tp_jax.gap.experiment import rehearsal
from tp_jax.gap.next_run import (
    NOTHING,
    Finding,
    Forecast,
    Limits,
    Run,
    finding_of,
    runs_to_compare,
)
from tp_jax.gap.policy import POLICY, ExplorePolicy
from tp_jax.gap.refit import Refit
from tp_jax.gap.screen import Scored


@dataclasses.dataclass(frozen=True)
class Alternative:
    """A model that may be the rig's.

    Attributes:
        values: all its numbers.
        unknowns: those that every run shares, which a run may move.
        information: (u, u) what the recordings so far tell of them.
        misfit: chi^2/dof that the model leaves, or is predicted to leave, of the recordings so far.
    """

    values: Values
    unknowns: tuple[Unknown, ...]
    information: np.ndarray
    misfit: float


def natural_frequency(numbers: Mapping[str, float]) -> float:
    """Frequency of column and rider together without friction [rad/s], by a model's parameters."""
    return float(np.sqrt(numbers["k"] / (numbers["B1"] + numbers.get("B2", 0.0))))


def forecasts(
    setting: PreparedCampaign,
    choice: Choice,
    first: str | None,
    rivals: Sequence[str],
    runs: Sequence[Run],
    duration: float,
    amplitude: float | None,
) -> tuple[Forecast, ...]:
    """Returns what each run is expected to do.

    Args:
        setting, choice: of a diagnosis.
        first, rivals: as in `Finding`.
        runs: to look at.
        duration: of a run [s].
        amplitude: of the drive [rad], where no recording was driven by a sine yet; None: not known,
            and driven runs are left out.
    """
    if not setting.sine:
        if amplitude is None:
            runs = [run for run in runs if run.omega is None]
    else:
        amplitude = None  # as it was fitted
    if not runs:
        return ()
    start = choice.rounds[0].before
    nothing = _of_fit(Refit(start, ()))
    truth = _alternative(choice, first, accepted=True) or nothing
    asked = {r: nothing if r == NOTHING else _alternative(choice, r) for r in rivals}
    others = {rival: model for rival, model in asked.items() if model is not None}
    states = np.zeros((len(runs), 4))
    states[:, 0] = [run.release or 0.0 for run in runs]
    still = rehearsal(setting, start, duration)
    every = range(len(runs))

    def followed(model: Alternative) -> list[np.ndarray]:
        table = _table(setting, model.values, runs, duration, amplitude)
        return still([None] * len(runs)).follow(table, every, states)

    motion = followed(truth)
    rest = {id(model): model for model in (nothing, *others.values()) if model is not truth}
    motions = [motion, *map(followed, rest.values())]
    baseline = motions[0 if truth is nothing else 1]
    # the baseline is fitted, others may be bold predictions that nothing can follow
    safe = [bool(np.isfinite(baseline[i]).all()) for i in every]
    largest = [_largest(setting, [m[i] for m in motions]) if safe[i] else None for i in every]
    whole = [i for i in every if np.isfinite(motion[i]).all()]
    told: list[dict[str, float]] = [{} for _ in runs]
    misfit = max(truth.misfit, 1.0)
    for rival, model in others.items() if whole else ():
        table = _table(setting, model.values, [runs[i] for i in whole], duration, amplitude)
        left = _left(still([motion[i] for i in whole]), table, model)
        for i, cost in zip(whole, left, strict=True):
            if np.isfinite(cost):
                told[i][rival] = 0.5 * float(cost) / misfit
    return tuple(Forecast(run, largest[i], told[i]) for i, run in enumerate(runs))


def _left(problem: Any, values: Values, model: Alternative) -> np.ndarray:
    """(r,) sums of squares that a model leaves of runs that it was not fitted to; NaN: it fails."""
    lin = problem.linearise(values, problem.initial_states(values), columns(model.unknowns))
    elim = eliminated(lin, model.unknowns)
    recording = problem.windows.recording
    of_runs = elim.sums(recording)
    left = []
    for i in range(len(problem.prepared)):
        mine = recording == i
        if not lin.complete[mine].all():
            left.append(np.nan)
            continue
        g, H = of_runs[0][i], of_runs[1][i] + model.information
        left.append(max(float(elim.cost[mine].sum() - g @ efficient_inverse(H) @ g), 0.0))
    return np.array(left)


def _largest(setting: PreparedCampaign, motions: Sequence[np.ndarray]) -> float:
    """Largest angle of any of the models that can be followed to the end [rad]."""
    channels = 2 if setting.rider else 1
    angles = [motion[:, :channels] for motion in motions]
    return float(max(np.abs(each).max() for each in angles if np.isfinite(each).all()))


def _table(
    setting: PreparedCampaign,
    values: Values,
    runs: Sequence[Run],
    duration: float,
    amplitude: float | None,
) -> Values:
    """The numbers of runs that were not made yet, those of the last fitted recording otherwise."""
    index = values.layout.index
    table = np.repeat(values.table[:, [setting.fitted[-1]]], len(runs), axis=1)
    driven = np.array([run.omega is not None for run in runs])
    table[index["omega"]] = [run.omega or 0.0 for run in runs]
    table[index["running"]], table[index["metered"]] = driven, 0.0
    table[index["drift_middle"]], table[index["drift_rate"]] = 0.5 * duration, 1.0 / duration
    if amplitude is not None:
        table[index["A"]] = amplitude
    return Values(values.layout, table)


def _alternative(choice: Choice, id: str | None, *, accepted: bool = False) -> Alternative | None:
    """The model with an effect: as accepted, else refitted, else as the screen predicts it.

    Rivals are models with one effect each. So is the first cause where there are more: what the
    others add would count against every rival.
    """
    if id is None:
        return None
    if accepted and choice.causes == (id,):
        return _of_fit(choice.final)
    first = choice.rounds[0]
    if id in first.refits:
        return _of_fit(first.refits[id])
    scored = next((s for s in first.screen.best() if s.id == id), None)
    if scored is None or any(u.recording is not None for u in scored.variant.unknowns):
        return None  # its amplitudes belong to recordings: a further one says nothing of them
    return _of_screen(first.before, scored)


def _of_fit(found: Refit) -> Alternative:
    fit = found.fit
    shared = [i for i, u in enumerate(fit.unknowns) if u.recording is None]
    rest = [i for i, u in enumerate(fit.unknowns) if u.recording is not None]
    kept = projected(fit.information(), shared, rest)
    shares = tuple(fit.unknowns[i] for i in shared)
    return Alternative(fit.values, shares, kept, fit.chi2_dof)


def _of_screen(fit: Fit, scored: Scored) -> Alternative:
    """One linearisation ahead of the fit, within the bounds."""
    base = [u for u, b in zip(fit.unknowns, fit.at_bound, strict=True) if not b]
    specs = [parameter(fit.problem, u) for u in base]
    moved = fit.values.pick(base) + scored.shift
    moved = np.clip(moved, [s.lower for s in specs], [s.upper for s in specs])
    at = fit.values.replace(scored.variant.settings)
    unknowns = [*base, *scored.variant.unknowns]
    lin = fit.problem.linearise(at, fit.states, columns(unknowns))
    H = eliminated(lin, unknowns).summed().H
    known = dict(zip(fit.unknowns, fit.normal().prior, strict=True))
    H[np.arange(len(base)), np.arange(len(base))] += [known[u] for u in base]
    values = at.put(base, moved).put(scored.variant.unknowns, scored.estimate)
    shared = [i for i, u in enumerate(unknowns) if u.recording is None]
    shares = tuple(unknowns[i] for i in shared)
    misfit = fit.chi2_dof - scored.drop / max(fit.dof, 1)
    return Alternative(values, shares, H[np.ix_(shared, shared)], misfit)


def outlook(
    examination: Examination,
    limits: Limits,
    duration: float,
    amplitude: float | None = None,
    policy: ExplorePolicy = POLICY.explore,
) -> Finding:
    """Returns what a diagnosis says of the next run, with forecasts of all that may come.

    Args:
        examination: the diagnosis with its fits.
        limits: of the rig.
        duration: of a run [s].
        amplitude: of the drive [rad], as the rig announces or its owner says it; used until a
            recording was driven.

    Raises:
        InputError: the drive's amplitude is not known, and no recording shows it.
    """
    setting, diagnosis = examination.setting, examination.diagnosis
    assert diagnosis.fits is not None  # it was just made
    if limits.drives and not setting.sine and amplitude is None:
        raise InputError(
            "The rig does not announce the amplitude of its drive, and no recording shows it yet; "
            "give it in rad as --amplitude, so that driven runs can be predicted."
        )
    found = finding_of(diagnosis, policy)
    runs = runs_to_compare(natural_frequency(diagnosis.fits.before.parameters), limits, policy)
    expected = forecasts(
        setting, examination.choice, found.first, list(found.rivals), runs, duration, amplitude
    )
    return dataclasses.replace(found, forecasts=expected)
