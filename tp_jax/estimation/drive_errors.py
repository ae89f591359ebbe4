"""Measured drives as the angles show them, within the errors that their readings leave.

The harmonics that stand for a noisy measured drive (`recordings.drive_noise`) have errors that are
the same all along a recording, and that no two recordings share. A phase that is off by a
thousandth moves the column by more than the noise of good angles: it looks like structure, and like
whatever differs from run to run. The angles tell such an error better than the readings do. So the
numbers of each drive are estimated anew with the baseline, from readings and angles together: one
Gauss-Newton step, with what the readings leave open as the prior.

A drive that would have to move further than noise explains is not wrong by its noise: it stays as
it reads, and what differs is left to the effects (`drive_delay`, `drive_harmonics`).
"""

import dataclasses
import logging

import numpy as np
from scipy import stats

from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.windows import pieces_of
from tp_jax.recordings import thinned
from tp_jax.recordings.drive_noise import PeriodicDrive, periodic

log = logging.getLogger(__name__)

CHANCE = 1e-3  # that noise moves the numbers of a drive further than is taken for its doing


def with_drives_of_angles(setting: PreparedCampaign, baseline: Fit) -> tuple[PreparedCampaign, Fit]:
    """A campaign whose noisy, periodic drives are estimated from readings and angles.

    Args:
        setting: the campaign. baseline: its fit.

    Returns:
        Both anew, or as they were where there is no such drive. Held-out recordings stay as they
        are.
    """
    found = {i: periodic(setting.campaign.recordings[i]) for i in setting.fitted}
    drives = {i: drive for i, drive in found.items() if drive is not None and drive.harmonics}
    if not drives:
        return setting, baseline
    moved = {}
    for i, z in _numbers(setting, baseline, drives).items():
        log.info("drive of %s: moved by %s standard errors", setting.recordings[i].name, z)
        if float(z @ z) < stats.chi2.isf(CHANCE, z.size):
            moved[i] = drives[i].values + drives[i].errors @ z
    if not moved:
        return setting, baseline
    setting = _with_drives(setting, moved)
    return setting, fit(
        setting.problem(baseline.problem.windows.horizon),
        baseline.values,
        baseline.unknowns,
        baseline.states,
        bounds=setting.bounds,
        priors=baseline.priors,
        relative=1e-7,
    )


def _numbers(
    setting: PreparedCampaign, baseline: Fit, drives: dict[int, PeriodicDrive]
) -> dict[int, np.ndarray]:
    """Moves (q,) of the numbers of each drive [standard errors], all unknowns moving with them."""
    problem, lin = baseline.problem, baseline.linearisation
    most = max(drive.errors.shape[1] for drive in drives.values())
    names = [f"drive number {j}" for j in range(most)]
    # no window has two recordings, so that one pass shows the same number of every drive
    answers = []
    for j in range(most):
        other = {i: d.values + d.errors[:, j] for i, d in drives.items() if j < d.errors.shape[1]}
        there = _through(problem, _with_drives(setting, other))
        answers.append(there.linearise(baseline.values, baseline.states, ()).r - lin.r)
    wide = dataclasses.replace(
        lin,
        slots=(*lin.slots, *names),
        slots_jac=np.concatenate([lin.slots_jac, np.stack(answers, axis=-1)], axis=-1),
    )
    own = {i: [Unknown(names[j], i) for j in range(d.errors.shape[1])] for i, d in drives.items()}
    added = [u for mine in own.values() for u in mine]
    unknowns = (*baseline.unknowns, *added)
    told, alone = eliminated(wide, unknowns).summed(), baseline.normal()
    g = np.concatenate([alone.g, told.g[len(baseline.unknowns) :]])
    information = told.H + np.diag([*alone.prior, *np.ones(len(added))])
    free = np.flatnonzero([*~baseline.at_bound, *np.ones(len(added), dtype=bool)])
    step = np.zeros(len(unknowns))
    step[free] = -scaled_inverse(information[np.ix_(free, free)]) @ g[free]
    place = {u: step[k] for k, u in enumerate(unknowns)}
    return {i: np.array([place[u] for u in mine]) for i, mine in own.items()}


def _through(problem: Problem, setting: PreparedCampaign) -> Problem:
    """The same windows of a campaign that differs in its drives."""
    return dataclasses.replace(problem, prepared=setting.prepared)


def _with_drives(setting: PreparedCampaign, values: dict[int, np.ndarray]) -> PreparedCampaign:
    """The campaign with other drives, by recording; each (n,) at the samples as recorded."""
    recordings, prepared = list(setting.recordings), list(setting.prepared)
    for i, drive in values.items():
        whole = dataclasses.replace(setting.campaign.recordings[i], drive=drive)
        thin = thinned(whole, setting.blocks[i], coarse=setting.coarse)
        recordings[i] = dataclasses.replace(recordings[i], drive=thin.drive)
        prepared[i] = dataclasses.replace(prepared[i], pieces=pieces_of(recordings[i]))
    return dataclasses.replace(setting, recordings=tuple(recordings), prepared=tuple(prepared))
