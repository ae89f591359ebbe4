"""The paper's way: Nelder-Mead on the free-run objective (17), from many starts side by side.

It ends in local minima from all but the nearest starts; it is here to be compared with.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jax.custom_batching import custom_vmap
from jaxtyping import Array

from tp_jax.estimation.fitted import parameter
from tp_jax.estimation.free_runs import FreeRuns
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.nelder_mead import NelderMead, Searched, minimise_many
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.simplex import Simplex, initial_simplex
from tp_jax.model.parameters import NUISANCES
from tp_jax.simulation.batch import threads_worthwhile

CONVERGED = "The simplex is smaller than its tolerances."
EXHAUSTED = "The limit of iterations or evaluations was reached."

ITERATIONS = 50  # as in Listing 1 of the paper

Progress = Callable[[str, float | None], None]


def free_run_search(
    setting: PreparedCampaign,
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
    ones = np.ones((len(starts), len(unknowns)))

    def count(lanes: Simplex) -> None:
        counted.append((float(lanes.iterations.mean()), len(lanes.iterations)))
        done = sum(mean * n for mean, n in counted[-len(shares) :])
        done /= len(starts) * max_iterations
        progress(f"Nelder-Mead on free runs, {len(starts)} starts", min(float(done), 1.0))

    function = _Scaled(FreeRuns(setting), starts[0], unknowns, limits)
    solver = NelderMead(rule="fminsearch", max_iterations=np.asarray(max_iterations))
    counted: list[tuple[float, int]] = []
    # every other start to the same thread: neighbours tend to take equally long
    threads = min(threads_worthwhile(), len(starts))
    shares = [np.arange(len(starts))[i::threads] for i in range(threads)]

    def search(share: np.ndarray) -> Searched:
        return minimise_many(
            function,
            solver,
            np.asarray(initial_simplex(ones[share])),
            (x0[share], size[share]),
            callback=count,
        )

    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(search, shares))
    order = np.argsort(np.concatenate(shares))
    found = Searched(*(np.concatenate(each)[order] for each in zip(*parts, strict=True)))
    best = x0 + (found.x - 1.0) * size
    return [
        (
            start.put(unknowns, np.clip(x, *limits.T)),
            float(y),
            int(evaluations),
            bool(ended),
            CONVERGED if ended else EXHAUSTED,
        )
        for start, x, y, evaluations, ended in zip(
            starts, best, found.value, found.evaluations, found.converged, strict=True
        )
    ]


class _Scaled(eqx.Module):
    """(17) in coordinates in which each unknown starts at one.

    base: (P, R) all numbers; owner: (P, R) which unknown is there, -1 for none; limits: (u, 2).
    """

    runs: FreeRuns
    base: np.ndarray
    owner: np.ndarray
    limits: np.ndarray

    def __init__(
        self, runs: FreeRuns, values: Values, unknowns: Sequence[Unknown], limits: np.ndarray
    ):
        slots = len(runs.layout.parameters)
        which = np.arange(len(unknowns), dtype=float)
        nobody = Values(values.layout, np.full_like(values.table, -1.0))
        self.runs, self.limits = runs, limits
        self.base = values.table[:slots]
        self.owner = nobody.put(unknowns, which).table[:slots].astype(int)

    def __call__(self, u: Array, lane: tuple[Array, Array], active: Array) -> Array:
        """The objective at u (n,), of a lane with start and size (n,) of the unknowns."""
        x0, size = lane
        x = jnp.clip(x0 + (u - 1.0) * size, *self.limits.T)
        return _value(self, x, active)

    def of_many(self, x: Array, active: Array | None) -> Array:
        """(17) of unknowns (m, u)."""
        tables = jnp.where(self.owner >= 0, x[:, self.owner], self.base)
        return self.runs.of_tables(tables, active)


def _value(scaled: _Scaled, x: Array, active: Array) -> Array:
    """(17) of unknowns (u,); mapped, all runs of all points are one batch."""
    arrays, static = eqx.partition(scaled, eqx.is_array_like)

    @custom_vmap
    def value(x, active, arrays):
        del active  # of a batch
        return eqx.combine(arrays, static).of_many(x[None], None)[0]

    @value.def_vmap
    def _(size, mapped, x, active, arrays):  # noqa: ARG001
        return eqx.combine(arrays, static).of_many(x, active), True

    return value(x, active, arrays)
