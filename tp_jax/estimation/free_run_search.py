"""The paper's way: Nelder-Mead on the free-run objective (17), from many starts side by side.

It ends in local minima from all but the nearest starts; it is here to be compared with.
"""

from collections.abc import Callable, Sequence

import numpy as np

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.free_runs import FreeRuns
from tp_jax.estimation.layout import Values
from tp_jax.estimation.least_squares import parameter
from tp_jax.estimation.nelder_mead_batch import CONVERGED, EXHAUSTED, minimise_batch
from tp_jax.estimation.simplex import Simplex, initial_simplex
from tp_jax.model.parameters import NUISANCES
from tp_jax.simulation.sweep import WIDTH

ITERATIONS = 50  # as in Listing 1 of the paper
AHEAD = 4  # points of an iteration that is evaluated ahead

Progress = Callable[[str, float | None], None]


def free_run_search(
    setting: Setting,
    starts: Sequence[Values],
    progress: Progress,
    *,
    max_iterations: int = ITERATIONS,
) -> list[tuple[Values, float, int, bool, str]]:
    """Searches the baseline's unknowns.

    In coordinates in which each unknown starts at one, so that `fminsearch`'s first simplex is
    the paper's: five per cent of each. A nuisance, whose zero means nothing, moves by five per
    cent of its typical size. Tolerances are `fminsearch`'s defaults.

    Args:
        setting: the campaign.
        starts: where to begin.
        progress: called with a stage's name and the part of it that is done.
        max_iterations: of each search.

    Returns:
        For each start the numbers found, the objective (17) [rad^2] there, evaluations, whether
        the simplex converged, and a sentence.
    """
    problem = setting.problem(setting.horizons[-1])
    unknowns = setting.unknowns()
    specs = [parameter(problem, u) for u in unknowns]
    limits = np.array([setting.bounds.get(s.name, (s.lower, s.upper)) for s in specs])
    x0 = np.array([np.clip(v.pick(unknowns), *limits.T) for v in starts])
    nuisance = np.isin([s.name for s in specs], [p.name for p in NUISANCES])
    typical = np.array([s.typical for s in specs])
    size = np.where(nuisance | (x0 == 0.0), typical, np.abs(x0))
    objective = FreeRuns(setting)
    base = starts[0]

    def evaluate(u: np.ndarray, lane: np.ndarray) -> np.ndarray:
        x = np.clip(x0[lane] + (u - 1.0) * size[lane], *limits.T)
        return objective([base.put(unknowns, each) for each in x])

    def count(lanes: Simplex) -> None:
        done = float(np.asarray(lanes.iterations).mean()) / max_iterations
        progress(f"Nelder-Mead on free runs, {len(starts)} starts", min(done, 1.0))

    # of few runs a call takes as long as of many
    ahead = AHEAD * len(starts) * len(setting.fitted) <= WIDTH
    ones = np.ones((len(starts), len(unknowns)))
    found = minimise_batch(
        evaluate, np.asarray(initial_simplex(ones)), ahead=ahead, rule="fminsearch",
        max_iterations=max_iterations, callback=count,
    )  # fmt: skip
    best = x0 + (found.x - 1.0) * size
    return [
        (
            start.put(unknowns, np.clip(x, *limits.T)), float(y), int(evaluations), bool(ended),
            CONVERGED if ended else EXHAUSTED,
        )
        for start, x, y, evaluations, ended in zip(
            starts, best, found.value, found.evaluations, found.converged, strict=True
        )
    ]  # fmt: skip
