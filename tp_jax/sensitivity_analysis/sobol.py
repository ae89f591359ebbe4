"""Variance-based global sensitivity: Sobol' indices through time.

The sampling (Saltelli's scheme on a scrambled Sobol' sequence) and the estimators are SALib's,
the runs the batch engine's. Besides the indices of each angle at each time there is one number for
a whole run: first and total variance summed over time, over the variance summed over time.

Sources: Saltelli et al. (2010), Computer Physics Communications 181, 259-270; for outputs that are
functions of time, Lamboni, Monod, Makowski (2011), Reliability Engineering & System Safety 96,
450-459, and Gamboa, Janon, Klein, Lagnoux (2014), Electronic Journal of Statistics 8, 575-603.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from tp_jax.identifiability.design import Design
from tp_jax.sensitivity_analysis.outputs import LEAST_SPREAD, motions, values_at
from tp_jax.sensitivity_analysis.ranges import Range

SAMPLES = 256
"""Points of the Sobol' sequence, a power of two; runs are so many times the parameters and two."""

TIMES = 61
RESAMPLES = 50


class Sobol(NamedTuple):
    """Sobol' indices of one experiment; a parameter without influence has a total of 0.

    label: of the experiment; names: (P,); t: (m,) s; variance: channel -> (m,) rad^2; first,
    total: channel -> (m, P), NaN where nothing varies yet; first_whole, total_whole: channel ->
    (P,) over the whole run; first_error, total_error: channel -> (P,) half widths of their 95 %
    intervals, from resampling, errors at different times taken for fully correlated; runs.
    """

    label: str
    names: tuple[str, ...]
    t: Float[np.ndarray, " m"]
    variance: dict[str, Float[np.ndarray, " m"]]
    first: dict[str, Float[np.ndarray, "m P"]]
    total: dict[str, Float[np.ndarray, "m P"]]
    first_whole: dict[str, Float[np.ndarray, " P"]]
    total_whole: dict[str, Float[np.ndarray, " P"]]
    first_error: dict[str, Float[np.ndarray, " P"]]
    total_error: dict[str, Float[np.ndarray, " P"]]
    runs: int


def sobol(
    design: Design,
    values: Mapping[str, float],
    over: Sequence[Range],
    *,
    samples: int = SAMPLES,
    times: int = TIMES,
    seed: int = 0,
) -> Sobol:
    """Sobol' indices of the angles in one experiment.

    Args:
        design: the experiment.
        values: what does not vary, by name, SI units.
        over: what does.
        samples: points of the sequence, a power of two.
        times: at how many of the design's times indices are computed.
        seed: of the scrambling and the resampling.
    """
    from SALib.sample import sobol as sampler

    unit = sampler.sample(unit_cube(over), samples, calc_second_order=False, seed=seed)
    angles = motions(design, values, values_at(unit, over))
    pick = np.unique(np.linspace(0, design.ts.size - 1, times).round().astype(int))
    variance, tables = {}, {}
    for channel, y in angles.items():
        variance[channel] = y[:, pick].var(axis=0)
        tables[channel] = np.stack([_indices(over, y[:, i], seed) for i in pick])
    names = tuple(r.name for r in over)
    first = {c: t[:, 0] for c, t in tables.items()}
    total = {c: t[:, 2] for c, t in tables.items()}
    whole = {c: _weighted(t, variance[c]) for c, t in tables.items()}
    first_whole, first_error, total_whole, total_error = (
        {c: w[i] for c, w in whole.items()} for i in range(4)
    )
    return Sobol(
        design.label,
        names,
        design.ts[pick],
        variance,
        first,
        total,
        first_whole,
        total_whole,
        first_error,
        total_error,
        len(unit),
    )


def unit_cube(over: Sequence[Range]) -> dict:
    """The problem as SALib describes it; values are taken from the cube by `Range.at`."""
    names = [r.name for r in over]
    return {"num_vars": len(over), "names": names, "bounds": [[0.0, 1.0]] * len(over)}


def _indices(over: Sequence[Range], y: np.ndarray, seed: int) -> np.ndarray:
    """S1, its half width, ST, its half width (4, P) of one output (N,)."""
    from SALib.analyze import sobol as analysis

    if y.std() < LEAST_SPREAD:
        return np.full((4, len(over)), np.nan)
    found = analysis.analyze(
        unit_cube(over),
        np.ascontiguousarray(y),
        calc_second_order=False,
        num_resamples=RESAMPLES,
        seed=seed + 1,  # SALib takes 0 for no seed
    )
    return np.array([found[k] for k in ("S1", "S1_conf", "ST", "ST_conf")], float)


def _weighted(table: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Means over time (4, P), weighted by the variance there."""
    known = np.isfinite(table).all(axis=(1, 2))
    if not known.any():
        return np.zeros(table.shape[1:])
    w = variance[known]
    return np.einsum("m,mkp->kp", w, table[known]) / w.sum()
