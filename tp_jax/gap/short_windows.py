"""Refits that begin anew in short windows, for the effects to which no way leads downhill."""

import logging

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.schedule import thinned
from tp_jax.estimation.variable_projection import fit
from tp_jax.estimation.window_states import warm_start_states
from tp_jax.gap.directions import variants
from tp_jax.gap.refit import Refit, coarse_drop, inside_bounds, with_shapes

log = logging.getLogger(__name__)


def refit_from_short_windows(
    setting: PreparedCampaign, before: Fit, trial: Refit, max_iterations: int = 20
) -> Refit:
    """The same effects fitted anew from the shortest windows, which are then lengthened.

    A wrong model pushes its parameters into a corner, and over long windows there may be no way
    downhill from there to where they belong once the effect is in; nor is a shape constant that
    looks best from that corner the right one. Over short windows there is a way, so the shape's
    whole grid is tried there. Some of these windows say as well which way it is (see `schedule`).

    Args:
        setting: the campaign.
        before: fit without the last effect, for the parameters.
        trial: direct refit from there.
        max_iterations: at each window length.

    Returns:
        Whichever is better, at the windows of `trial`.
    """
    *others, last = trial.variants
    constants = {last.effect.qualified(s.name) for s in last.effect.shapes}
    unknowns = [u for u in trial.fit.unknowns if u.name not in constants]  # from the grid
    _, bounds = with_shapes(setting, trial)
    target = trial.fit.problem.windows.horizon
    horizons = [*(h for h in setting.horizons if h < 0.99 * target), target]
    stuck = [u for u, b in zip(before.unknowns, before.at_bound, strict=True) if b]
    start = trial.fit.values.put(before.unknowns, before.values.pick(before.unknowns))
    start = start.replace({u.name: 0.0 for u in last.unknowns})
    start = start.replace(inside_bounds(before.problem, stuck))
    best: Fit | None = None
    chosen = last
    coarse = coarse_drop(before)
    problem = thinned(setting.problem(horizons[0]))
    for variant in variants(last.effect, setting):
        found = fit(
            problem,
            start.replace(variant.settings),
            unknowns,
            bounds=bounds,
            priors=trial.fit.priors,
            max_iterations=max_iterations // 2,
            tolerance=10.0 * coarse * _share(problem, before),
            relative=0.0,
        )
        if best is None or found.cost < best.cost:
            best, chosen = found, variant
    assert best is not None
    for horizon in horizons:
        problem = setting.problem(horizon)
        if horizon != target:
            problem = thinned(problem)
        best = fit(
            problem,
            best.values,
            unknowns,
            warm_start_states(best, problem),
            bounds=bounds,
            priors=trial.fit.priors,
            max_iterations=max_iterations,
            tolerance=coarse * _share(problem, before),
            relative=0.0,
        )
    log.info(
        "%s regrown, %s: chi2/dof %.4g, %s",
        "+".join(trial.ids),
        chosen.shapes,
        best.chi2_dof,
        best.message,
    )
    better = np.isfinite(best.cost) and best.cost < trial.cost
    return Refit(best, (*others, chosen)) if better else trial


def _share(problem: Problem, before: Fit) -> float:
    """Part of a fit's samples that a problem has."""
    return min(float(problem.windows.count.sum() / before.problem.windows.count.sum()), 1.0)
