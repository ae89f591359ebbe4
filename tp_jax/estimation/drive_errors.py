"""Measured drives as the angles show them, within the errors that their readings leave.

The harmonics that stand for a noisy measured drive (`recordings.drive_noise`) have errors that are
the same all along a recording, and that no two recordings share. A phase that is off by a
thousandth moves the column by more than the noise of good angles: it looks like structure, and like
whatever differs from run to run. The angles tell such an error better than the readings do. So the
numbers of each drive are estimated anew with the baseline, from readings and angles together: one
Gauss-Newton step, with what the readings leave open as the prior.

A drive that would have to move further than noise explains is not wrong by its noise: it stays as
it reads, and what differs is left to the effects (`drive_delay`, `drive_harmonics`). So do all of
them where together they would move further, as under a delay that all runs have; once the delay is
in the model they are asked again. The angles count for less where the baseline leaves more than
noise, since some of that is a gap. What is estimated so has errors, which intervals take in.
"""

import dataclasses
import logging
from collections.abc import Sequence

import numpy as np
from scipy import stats

from tp_jax.estimation.elimination import Eliminated, eliminated
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.schedule import refitted
from tp_jax.estimation.windows import pieces_of
from tp_jax.recordings import thinned
from tp_jax.recordings.drive_noise import PeriodicDrive, periodic

log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class DriveErrorsPolicy:
    """Conditions under which a drive is put right.

    Attributes:
        chance: that noise moves the numbers of a drive, or of all of them, further than is taken
            for its doing; one campaign in a thousand keeps its drives as they are for nothing.
        told: part of a number's variance that angles tell, below which a move of it is rounding.
    """

    chance: float = 1e-3
    told: float = 1e-3


POLICY = DriveErrorsPolicy()


def with_drives_of_angles(
    setting: PreparedCampaign,
    baseline: Fit,
    bounds: dict[str, tuple[float, float]] | None = None,
    kinks: bool = False,
) -> tuple[PreparedCampaign, Fit]:
    """A campaign whose noisy, periodic drives are estimated from readings and angles.

    Those that are not yet; the others stay.

    Args:
        setting: the campaign. baseline: its fit, of causes too. bounds, kinks: see `refitted`.

    Returns:
        Both anew, or as they were where there is no such drive.
    """
    left = [i for i in setting.fitted if i not in setting.drives]
    moved, pull = put_right(setting, baseline, left)
    if moved is setting:
        return setting, baseline
    found = refitted(moved, baseline, bounds, kinks)
    # a step along kinks may not keep what its slope promised
    return (moved, found) if found.cost + pull < baseline.cost else (setting, baseline)


def put_right(
    setting: PreparedCampaign, fit: Fit, which: Sequence[int]
) -> tuple[PreparedCampaign, float]:
    """The campaign with the drives of some recordings put right, and the sum of squares of that.

    Args:
        setting: the campaign.
        fit: to the recordings; where a model is only predicted, of their windows' states alone.
        which: recordings.
    """
    found = {i: periodic(setting.campaign.recordings[i]) for i in which}
    drives = {i: drive for i, drive in found.items() if drive is not None and drive.harmonics}
    if not drives:
        return setting, 0.0
    moves = _moves(setting, fit, drives)
    tests = {i: _test(move) for i, move in moves.items()}
    every = float(stats.chi2.sf(*np.sum(list(tests.values()), axis=0))) if tests else 0.0
    log.info("drives moved [standard errors]: %s, p of all %.3g", moves, every)
    kept = [i for i, test in tests.items() if min(stats.chi2.sf(*test), every) > POLICY.chance]
    if not kept:
        return setting, 0.0
    right = {i: drives[i].moved(moves[i].numbers) for i in kept}
    moved = dataclasses.replace(_with_drives(setting, right), drives=setting.drives | right)
    return moved, sum(float(moves[i].numbers @ moves[i].numbers) for i in kept)


@dataclasses.dataclass(frozen=True)
class _Move:
    """Moves (q,) of the numbers of a drive [standard errors], and their covariance (q, q) where
    noise alone makes them."""

    numbers: np.ndarray
    scatter: np.ndarray


def _test(move: _Move) -> tuple[float, int]:
    """Sum of squares of a move in units of its scatter, and of how many numbers the angles tell."""
    value, vector = np.linalg.eigh(move.scatter)
    told = value > POLICY.told
    return float(((vector[:, told].T @ move.numbers) ** 2 / value[told]).sum()), int(told.sum())


def _moves(
    setting: PreparedCampaign, baseline: Fit, drives: dict[int, PeriodicDrive]
) -> dict[int, _Move]:
    """Moves of each drive, all unknowns moving with them; none where one cannot be integrated."""
    widened = _widened(setting, baseline, drives)
    if widened is None:
        return {}
    told, own = widened[0].summed(), widened[1]
    alone, added = baseline.normal(), [u for mine in own.values() for u in mine]
    unknowns = (*baseline.unknowns, *added)
    misfit = max(baseline.chi2_dof, 1.0)
    g = np.concatenate([alone.g, told.g[len(baseline.unknowns) :]]) / misfit
    information = (told.H + np.diag([*alone.prior, *np.zeros(len(added))])) / misfit
    information += np.diag([*np.zeros(len(baseline.unknowns)), *np.ones(len(added))])
    free = np.flatnonzero([*~baseline.at_bound, *np.ones(len(added), dtype=bool)])
    covariance = np.zeros(information.shape)
    covariance[np.ix_(free, free)] = scaled_inverse(information[np.ix_(free, free)])
    place = {u: k for k, u in enumerate(unknowns)}
    mine = {i: [place[u] for u in names] for i, names in own.items()}
    step = -covariance @ g
    return {
        i: _Move(step[at], np.eye(len(at)) - covariance[np.ix_(at, at)]) for i, at in mine.items()
    }


@dataclasses.dataclass(frozen=True)
class DrivesOut:
    """A fit's windows with the numbers of drives re-optimised, which were put right by the angles.

    Those are estimates too, and move with the unknowns: with the delay of a drive, above all.

    Attributes:
        told: windows, by the fit's unknowns (u) and then by those numbers (q).
        following: (u + q, u) how both move with the unknowns.
        H: (u, u) information of the data about the unknowns.
    """

    told: Eliminated
    following: np.ndarray
    H: np.ndarray

    def sums(self, group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gradients (G, u) and information (G, u, u) of groups of windows: see `Eliminated`."""
        g, H = self.told.sums(group)
        return g @ self.following, self.following.T @ H @ self.following


def drives_out(setting: PreparedCampaign, fit: Fit) -> DrivesOut:
    """A fit with the numbers of its drives re-optimised, within what their readings leave open."""
    count = len(fit.unknowns)
    widened = _widened(setting, fit, setting.drives) if setting.drives else None
    if widened is None:
        return DrivesOut(fit.eliminated, np.eye(count), fit.normal().H)
    H = widened[0].summed().H
    H[count:, count:] += np.eye(len(H) - count)
    following = np.concatenate(
        [np.eye(count), -np.linalg.solve(H[count:, count:], H[count:, :count])]
    )
    return DrivesOut(widened[0], following, following.T @ H @ following)


def _widened(
    setting: PreparedCampaign, fit: Fit, drives: dict[int, PeriodicDrive]
) -> tuple[Eliminated, dict[int, list[Unknown]]] | None:
    """A fit's windows by its unknowns and then by the numbers of drives, and those by recording.

    None where a drive that is off by one of its errors cannot be integrated.
    """
    problem, lin = fit.problem, fit.linearisation
    most = max(drive.errors.shape[1] for drive in drives.values())
    names = [f"drive number {j}" for j in range(most)]
    # no window has two recordings, so that one pass shows the same number of every drive
    answers = []
    for j in range(most):
        other = {}
        for i, drive in drives.items():
            if j < (q := drive.errors.shape[1]):
                other[i] = drive.moved(np.eye(q)[j])
        there = dataclasses.replace(problem, prepared=_with_drives(setting, other).prepared)
        answer = there.linearise(fit.values, fit.states, ())
        if not answer.complete.all():
            return None
        answers.append(answer.r - lin.r)
    wide = dataclasses.replace(
        lin,
        slots=(*lin.slots, *names),
        slots_jac=np.concatenate([lin.slots_jac, np.stack(answers, axis=-1)], axis=-1),
    )
    own = {i: [Unknown(names[j], i) for j in range(d.errors.shape[1])] for i, d in drives.items()}
    added = [u for mine in own.values() for u in mine]
    return eliminated(wide, (*fit.unknowns, *added)), own


def _with_drives(setting: PreparedCampaign, drives: dict[int, PeriodicDrive]) -> PreparedCampaign:
    """The campaign with other drives, by recording."""
    recordings, prepared = list(setting.recordings), list(setting.prepared)
    for i, drive in drives.items():
        whole = dataclasses.replace(setting.campaign.recordings[i], drive=drive.values)
        thin = thinned(whole, setting.blocks[i], coarse=setting.coarse)
        recordings[i] = dataclasses.replace(recordings[i], drive=thin.drive)
        prepared[i] = dataclasses.replace(prepared[i], pieces=pieces_of(recordings[i]))
    return dataclasses.replace(setting, recordings=tuple(recordings), prepared=tuple(prepared))
