"""The next experiment: which run would tell two effects apart that these data cannot."""

from collections.abc import Callable, Sequence

import numpy as np

from tp_jax.estimation.elimination import eliminated
from tp_jax.estimation.fitted import Fit, parameter
from tp_jax.estimation.layout import Values
from tp_jax.estimation.linearisation import columns
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem, room
from tp_jax.estimation.windows import Prepared, cut
from tp_jax.gap.screen import Scored
from tp_jax.results.diagnosis import NextExperiment

DURATION = 10.0
"""Length of a run that is proposed [s], at least."""

PERIODS = 10.0
"""Periods of the motion that it has at least: less tells little of a slow rig."""


def rehearsal(
    setting: PreparedCampaign, fit: Fit, duration: float
) -> Callable[[Sequence[np.ndarray | None]], Problem]:
    """Makes problems of runs that were not made: from their readings, windows as those of a fit.

    Args:
        setting: whose programs they have, and of whose first fitted recording the sampling and the
            noise. fit: whose windows are as long.
        duration: of every run [s].

    Returns:
        readings (n, 2) [rad] of each run, None: zeros -> a `Problem` of those runs.
    """
    like = setting.prepared[setting.fitted[0]]
    step = float(np.median(np.diff(like.t)))
    t = np.arange(0.0, duration + 0.5 * step, step)
    sd = np.concatenate([np.tile(like.sigma, (t.size, 1)), np.ones((t.size, 2))], axis=1)

    def problem_of(readings: Sequence[np.ndarray | None]) -> Problem:
        prepared = []
        for given in readings:
            y = np.zeros((t.size, 2)) if given is None else given
            smooth = np.concatenate([y, np.gradient(y, t, axis=0)], axis=1)
            channels = np.array([True, setting.rider])
            prepared.append(
                Prepared(t, y, channels, smooth, sd, None, sigma=like.sigma, colour=like.colour)
            )
        windows = cut(prepared, fit.problem.windows.horizon)
        capacity = room(windows, setting.capacity)
        return Problem(
            setting.layout,
            tuple(prepared),
            windows,
            capacity,
            setting.fixed["B1"],
            programs=setting.programs,
        )

    return problem_of


def propose(setting: PreparedCampaign, fit: Fit, a: Scored, b: Scored) -> NextExperiment | None:
    """The best of a few sine runs; None where the drive is measured or no sine can be set."""
    omegas = [r.omega for r in setting.recordings if r.forced and r.omega]
    if not setting.sine or not omegas:
        return None
    asked = np.linspace(0.7 * min(omegas), 1.15 * max(omegas), 6)
    grid = np.unique([float(f"{omega:.4g}") for omega in asked])
    duration = max(DURATION, float(f"{PERIODS * setting.period:.2g}"))
    table = []
    for omega in grid:
        column = fit.values.table[:, setting.fitted[-1]].copy()
        index = setting.layout.index
        column[index["omega"]], column[index["running"]], column[index["metered"]] = omega, 1.0, 0.0
        column[index["drift_middle"]], column[index["drift_rate"]] = 0.5 * duration, 1.0 / duration
        table.append(column)
    values = Values(setting.layout, np.array(table).T)
    problem_of = rehearsal(setting, fit, duration)
    nothing = problem_of([None] * grid.size)
    problem = problem_of(nothing.follow(values, range(grid.size), np.zeros((grid.size, 4))))
    windows = problem.windows
    base = [u for u in fit.unknowns if u.recording is None]
    effects = [u for s in (a, b) for u in s.variant.unknowns if u.recording is None]
    if len(effects) < 2:
        return None
    values = values.replace({**a.variant.settings, **b.variant.settings})
    unknowns = [*base, *effects]
    lin = problem.linearise(values, problem.initial_states(values), columns(unknowns))
    if not lin.complete.all():
        return None
    _, of_runs = eliminated(lin, unknowns).sums(windows.recording)
    nb, qa = len(base), len(a.variant.unknowns)
    ea = a.estimate
    if not np.any(ea):
        ea = np.array([parameter(problem, u).typical for u in a.variant.unknowns])
    sigmas = []
    for i in range(grid.size):
        H = of_runs[i]
        # How much of effect a's trace is left when the parameters and effect b absorb what they
        # can on this run.
        others = [j for j in range(len(unknowns)) if not nb <= j < nb + qa]
        mine = list(range(nb, nb + qa))
        V = (
            H[np.ix_(mine, mine)]
            - H[np.ix_(mine, others)]
            @ efficient_inverse(H[np.ix_(others, others)])
            @ H[np.ix_(others, mine)]
        )
        sigmas.append(float(np.sqrt(max(ea @ V @ ea, 0.0))))
    best = int(np.argmax(sigmas))
    return NextExperiment(
        omega=float(grid[best]),
        forced=True,
        duration=duration,
        separates=(a.id, b.id),
        expected_sigma=sigmas[best],
    )
