"""Predictions of a model for motions that it was not fitted to.

Groups of windows (whole recordings, or long spans where there are few) are left out in turn. The
unknowns move to where a fit without the group would have them, and the group is predicted: in the
windows of the fit, and in longer ones, where an error of the model has time to grow. Only the
windows' states are estimated there, and the zeros of that recording. What belongs to a recording
that was left out is what the others have in common.
"""

import dataclasses
import functools
from collections.abc import Callable, Collection

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import room
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import of_windows, warm_start_states
from tp_jax.estimation.windows import cut
from tp_jax.gap.crossvalidation import moves
from tp_jax.gap.held_out import expected_elsewhere
from tp_jax.gap.policy import ConfirmPolicy, FoldPolicy
from tp_jax.gap.refit import Refit, with_shapes

ZEROS = ("zero2",)


def groups(
    setting: PreparedCampaign, fit: Fit, policy: FoldPolicy, within: bool = False
) -> np.ndarray:
    """Group of each window (w,): recordings, or spans of them where there are few.

    Args:
        setting: the campaign. fit: some of its windows. policy: how many groups.
        within: halves of recordings, for what differs from one to another.
    """
    w = fit.problem.windows
    which = np.unique(w.recording)
    spans = max(2 if within else 1, int(np.ceil(policy.groups / which.size)))
    needed = int(np.ceil(policy.fewest / which.size))
    out = np.zeros(w.n, dtype=int)
    count = 0
    for r in which:
        mine = np.flatnonzero(w.recording == r)
        t = setting.prepared[r].t
        periods = (t[-1] - t[0]) / setting.period
        n = min(spans, periods / policy.periods)
        n = max(n, min(needed, periods / policy.least_periods))
        n = int(np.clip(n, 1, mine.size))
        part = np.minimum(np.arange(mine.size) * n // mine.size, n - 1)
        out[mine] = count + part
        count += n
    return out


@dataclasses.dataclass(frozen=True)
class LeftOut:
    """Errors of a model on groups that it was not fitted to.

    short: (G,) sums of squares in units of the noise, in the windows of the fit; unknowns: (G, u)
    fitted without each group; over_long: computes `long`, for which all windows are fitted once
    more: most causes that are refused are so by the short ones.
    """

    short: np.ndarray
    unknowns: np.ndarray
    over_long: Callable[[], np.ndarray]

    @functools.cached_property
    def long(self) -> np.ndarray:
        """(G,) mean squares [rad^2] over long windows, NaN where it could not be integrated."""
        return self.over_long()


def left_out(
    setting: PreparedCampaign,
    result: Refit,
    group: np.ndarray,
    policy: ConfirmPolicy,
    alone: Collection[int] = (),
) -> LeftOut:
    """Predicts each group by the model as it would be fitted without the group.

    The unknowns move by one Newton step (`crossvalidation.moves`), which costs no simulation and
    sends what the group alone tells of nowhere; the group is then simulated anew. Such a step means
    nothing where a group holds nearly all that is known of something: without those the model is
    fitted again.

    Args:
        setting: the campaign.
        result: fitted to all of it.
        group: of each window, see `groups`.
        policy: how long the long windows are.
        alone: groups without which the model is fitted again.
    """
    whole = result.fit
    windows = whole.problem.windows
    found = moves(whole, group)
    short, unknowns, later = [], [], []
    for g in np.unique(group):
        inside = group == g
        gone = set(windows.recording[inside]) - set(windows.recording[~inside])
        seen = sorted(set(windows.recording[~inside]))
        values = found.values(whole, g)
        if g in alone:
            free = [u for u in found.unknowns if u.recording not in gone]
            values = _fitted_without(setting, result, inside, values, free)
        values = expected_elsewhere(values, setting, seen, sorted(gone))
        free = [u for u in whole.unknowns if u.recording in gone and u.name in ZEROS]
        mine = np.flatnonzero(inside)
        there = _states_fitted(result, values, free, mine, None)
        short.append(there.linearisation.cost())
        later.append(functools.partial(_over_long, result, values, free, mine, policy.long))
        unknowns.append(values.pick(whole.unknowns))
    return LeftOut(
        np.array(short), np.array(unknowns), lambda: np.array([error() for error in later])
    )


def _over_long(
    result: Refit, values: Values, free: list[Unknown], mine: np.ndarray, factor: float
) -> float:
    """Mean square [rad^2] of a group's error in windows so many times longer; NaN: no answer."""
    longer = _states_fitted(result, values, free, mine, factor)
    error = longer.linearisation.samples * np.tile(
        longer.problem.sigma, longer.linearisation.n_samples
    )
    valid = longer.linearisation.valid[:, :-4]
    if not (longer.linearisation.complete.all() and valid.any()):
        return np.nan
    return float((error[valid] ** 2).mean())


def _fitted_without(
    setting: PreparedCampaign,
    result: Refit,
    inside: np.ndarray,
    values: Values,
    free: list[Unknown],
) -> Values:
    """The numbers of a model that is fitted to all windows but those of a group."""
    whole = result.fit
    outside = np.flatnonzero(~inside)
    _, bounds = with_shapes(setting, result)
    found = fit(
        of_windows(whole.problem, outside),
        values,
        free,
        whole.states[outside],
        bounds=bounds,
        priors=[a for a in whole.priors if a.unknown in free],
        max_iterations=12,
        relative=1e-5,
    )
    return found.values if np.isfinite(found.cost) else values


def shares(result: Refit, group: np.ndarray) -> np.ndarray:
    """Parts (G,) of what is known of the last cause's amplitudes that each group tells.

    Args:
        result: with the cause.
        group: of each window.
    """
    fit = result.fit
    mine = [fit.unknowns.index(u) for u in result.variants[-1].unknowns if u in fit.unknowns]
    H = fit.eliminated.sums(group)[1][:, mine][:, :, mine]
    inverse = scaled_inverse(H.sum(axis=0))
    return np.einsum("ij,gji->g", inverse, H) / max(len(mine), 1)


def largest_share(result: Refit) -> float:
    """Part of what is known of the last cause's amplitudes that one recording tells.

    Args:
        result: with the cause.
    """
    _, recording = np.unique(result.fit.problem.windows.recording, return_inverse=True)
    return float(shares(result, recording).max())


def _states_fitted(
    result: Refit,
    values: Values,
    free: list[Unknown],
    mine: np.ndarray,
    factor: float | None,
) -> Fit:
    """The windows of a group, or longer ones over the same samples, with their states fitted."""
    whole = result.fit
    problem, states = of_windows(whole.problem, mine), whole.states[mine]
    if factor is not None:
        w = problem.windows
        # as long as the program at hand takes
        step = min(float(np.median(np.diff(whole.problem.prepared[r].t))) for r in w.recording)
        most = 0.7 * problem.capacity * step  # a cut may be half as long again
        long = cut(list(whole.problem.prepared), min(factor * w.horizon, most))
        first = {r: int(w.first[w.recording == r].min()) for r in set(w.recording)}
        last = {r: int((w.first + w.count)[w.recording == r].max()) for r in set(w.recording)}
        keep = [
            i
            for i, r in enumerate(long.recording)
            if r in first and long.first[i] < last[r] and long.first[i] + long.count[i] > first[r]
        ]
        begin = np.array([max(long.first[i], first[long.recording[i]]) for i in keep])
        end = np.array([min(long.first[i] + long.count[i], last[long.recording[i]]) for i in keep])
        enough = end - begin >= 8
        clipped = dataclasses.replace(
            long,
            recording=long.recording[keep][enough],
            first=begin[enough],
            count=(end - begin)[enough],
        )
        problem = dataclasses.replace(
            problem, windows=clipped, capacity=room(clipped, problem.capacity)
        )
        states = warm_start_states(whole, problem)
    return fit(
        problem,
        values,
        free,
        states,
        priors=[a for a in whole.priors if a.unknown in free],
        max_iterations=12,
        relative=1e-5,
    )
