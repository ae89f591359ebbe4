"""The baseline fit of a campaign: start from the data, then a schedule of window lengths.

Short windows are convex enough to be found from afar; long ones say more. The horizon follows the
sampling and the period of the motion, the smoothing of the friction is raised as the windows
grow.
"""

import logging
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign, is_sine
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.start import start_from_data
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import of_windows
from tp_jax.model.parameters import PAPER_EPS
from tp_jax.model.pendulum import NEWTON_REACTION, PRINTED_REACTION

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]

PATIENCE = 100  # steps of a fit: far from a rider that hardly moves, some rigs need more than 50

MOST_WINDOWS = 160
"""Windows of a fit that only leads to the next one: more say no better which valley it is."""

DIED = 3.0
"""T0 times a slip speed from which the contact's exponential has died out there, to a twentieth.
Where it has at nine tenths of all speeds, no derivative leads back to where it had not."""


def initial_values(setting: PreparedCampaign) -> Values:
    """All numbers before any fit: the data's own start, and what is given."""
    campaign = setting.campaign
    B1 = setting.fixed["B1"]
    fitted = [setting.recordings[i] for i in setting.fitted]
    given = {n: v for n, v in setting.fixed.items() if n in ("B2", "k")}
    sigma = {"phi1": setting.sigma[0], "phi2": setting.sigma[1]}
    start = start_from_data(fitted, sigma, setting.widths[setting.fitted], B1, given)
    if setting.model == "paper":  # the printed model with all of the column's numbers doubled
        for name in ("B2", "Tv", "Ts1", "Tst"):
            if name in start and name not in given:
                start[name] *= 0.5
    middle, rate = (list(each) for each in zip(*(r.drift for r in setting.recordings), strict=True))
    clocks = [r.start for r in setting.recordings]
    if all(c is not None for c in clocks):  # drifts run on the campaign's clock
        begin = min(c + r.t[0] for c, r in zip(clocks, setting.recordings, strict=True))
        end = max(c + r.t[-1] for c, r in zip(clocks, setting.recordings, strict=True))
        middle = [0.5 * (begin + end) - c for c in clocks]
        rate = [1.0 / (end - begin)] * len(clocks)
    paper = setting.model == "paper"
    values: dict[str, object] = {
        "B1": B1,
        "B2": B1,
        "k": B1,
        "T0": 1.0,
        "eps1": setting.eps,
        "eps2": setting.eps,
        "reaction": PRINTED_REACTION if paper else NEWTON_REACTION,
        "omega": [r.omega if is_sine(r) else 0.0 for r in setting.recordings],
        "running": [float(is_sine(r)) for r in setting.recordings],
        "metered": [float(r.measured_drive) for r in setting.recordings],
        "drift_middle": middle,
        "drift_rate": rate,
    }
    out = Values.build(setting.layout, len(campaign.recordings), {**values, **start})
    return out.replace(setting.fixed)


def fit_over_schedule(
    setting: PreparedCampaign,
    values: Values,
    unknowns: Sequence[Unknown],
    *,
    horizons: Sequence[float] | None = None,
    which: Sequence[int] | None = None,
    progress: Progress | None = None,
    max_iterations: int = PATIENCE,
) -> Fit:
    """Fits on a schedule of window lengths, with the friction's smoothing raised on the way."""
    horizons = setting.horizons if horizons is None else horizons
    schedule = np.minimum(
        np.geomspace(PAPER_EPS, setting.eps, max(len(horizons) - 1, 1)), setting.eps
    )
    result: Fit | None = None
    for i, horizon in enumerate(horizons):
        if progress is not None:
            stage = f"fitting windows: {horizon:.2g} s, {i + 1} of {len(horizons)}"
            progress(stage, i / len(horizons))
        problem = setting.problem(horizon, which)
        last = i + 1 == len(horizons)
        if not last:
            problem = of_windows(problem, few_of(problem.windows.n))
        eps = setting.eps if last else float(schedule[i])
        values = values.replace({"eps1": eps, "eps2": eps})
        states = None if result is None else warm_start_states(result, problem)
        how: dict[str, Any] = dict(
            bounds=setting.bounds,
            priors=[a for a in setting.priors() if a.unknown in unknowns],
            max_iterations=max_iterations,
            relative=1e-3 if i + 1 < len(horizons) else 1e-7,
        )
        result = fit(problem, values, unknowns, states, **how)
        if last:
            result = _slower(setting, result, how)
        values = result.values
        log.info("windows of %.3g s: chi2/dof %.4g, %s", horizon, result.chi2_dof, result.message)
    assert result is not None
    return result


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


def _slower(setting: PreparedCampaign, found: Fit, how: dict[str, Any]) -> Fit:
    """The better of two fits: as found, and sought where its contact rises at speeds that are met.

    Only where that found rises at speeds too small to be met.
    """
    if Unknown("T0") not in found.unknowns or not np.isfinite(found.cost):
        return found
    speed = np.concatenate([np.abs(setting.prepared[i].path[:, 3]) for i in setting.fitted])
    if not (found.values.get("Tst") and speed.any()):  # then T0 is of no matter
        return found
    speed = speed[speed > 0.1 * speed.max()]  # of a rider that sticks it is noise
    if found.values.get("T0") * np.quantile(speed, 0.1) < DIED:
        return found
    start = found.values.replace({"T0": 1.0 / float(np.median(speed))})
    # held there first, or the others, which are those of another contact, would drive it back
    others = [u for u in found.unknowns if u.name != "T0"]
    priors = [a for a in how["priors"] if a.unknown.name != "T0"]
    held = fit(found.problem, start, others, found.states, **{**how, "priors": priors})
    other = fit(found.problem, held.values, found.unknowns, held.states, **how)
    log.info(
        "T0 %.3g instead of %.3g: chi2/dof %.5g, was %.5g",
        other.values.get("T0"),
        found.values.get("T0"),
        other.chi2_dof,
        found.chi2_dof,
    )
    return min(found, other, key=lambda one: one.cost)


def warm_start_states(before: Fit, problem: Problem) -> np.ndarray:
    """Window states for a new cut, read off the trajectories of the last one."""
    states = problem.initial_states(before.values)
    old, new = before.problem.windows, problem.windows
    for i in range(new.n):
        same = np.flatnonzero(
            (old.recording == new.recording[i])
            & (old.first <= new.first[i])
            & (new.first[i] < old.first + old.count)
        )
        if same.size:
            j = same[0]
            states[i] = before.linearisation.states[j, new.first[i] - old.first[j], :4]
    return states
