"""Screening by elementary effects: mean size and spread of what one parameter's step does.

Sampling and statistics are SALib's, the runs the batch engine's. A parameter with mu* of nothing
can be left out; sigma large beside mu* means that its effect depends on the others.

Sources: Morris (1991), Technometrics 33, 161-174; Campolongo, Cariboni, Saltelli (2007),
Environmental Modelling & Software 22, 1509-1518.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from tp_jax.identifiability.design import Design
from tp_jax.sensitivity_analysis.outputs import motions, values_at
from tp_jax.sensitivity_analysis.ranges import Range
from tp_jax.sensitivity_analysis.sobol import TIMES, unit_cube

TRAJECTORIES = 64
LEVELS = 4
RESAMPLES = 50


class Morris(NamedTuple):
    """Elementary effects in one experiment, each per whole range of its parameter.

    label: of the experiment; names: (P,); t: (m,) s; mu_star: channel -> (m, P) mean size [rad];
    sigma: channel -> (m, P) standard deviation [rad]; mu_star_whole, sigma_whole: channel -> (P,)
    roots of their mean squares over time [rad]; mu_star_error: channel -> (P,) half width of the
    95 % interval of the former, from resampling [rad]; runs.
    """

    label: str
    names: tuple[str, ...]
    t: Float[np.ndarray, " m"]
    mu_star: dict[str, Float[np.ndarray, "m P"]]
    sigma: dict[str, Float[np.ndarray, "m P"]]
    mu_star_whole: dict[str, Float[np.ndarray, " P"]]
    sigma_whole: dict[str, Float[np.ndarray, " P"]]
    mu_star_error: dict[str, Float[np.ndarray, " P"]]
    runs: int


def morris(
    design: Design,
    values: Mapping[str, float],
    over: Sequence[Range],
    *,
    trajectories: int = TRAJECTORIES,
    times: int = TIMES,
    seed: int = 0,
) -> Morris:
    """Elementary effects on the angles in one experiment.

    Args:
        design: the experiment.
        values: what does not vary, by name, SI units.
        over: what does.
        trajectories: how many; runs are so many times the parameters and one.
        times: at how many of the design's times.
        seed: of the draw and the resampling.
    """
    from SALib.analyze import morris as analysis
    from SALib.sample import morris as sampler

    unit = sampler.sample(unit_cube(over), trajectories, num_levels=LEVELS, seed=seed)
    angles = motions(design, values, values_at(unit, over))
    pick = np.unique(np.linspace(0, design.ts.size - 1, times).round().astype(int))
    tables = {}
    for channel, y in angles.items():
        rows = []
        for i in pick:
            found = analysis.analyze(
                {**unit_cube(over), "groups": None},
                unit,
                np.ascontiguousarray(y[:, i]),
                num_levels=LEVELS,
                num_resamples=RESAMPLES,
                seed=seed,
            )
            rows.append([np.asarray(found[k], float) for k in ("mu_star", "sigma", "mu_star_conf")])
        tables[channel] = np.array(rows)
    whole = {c: np.sqrt((t**2).mean(axis=0)) for c, t in tables.items()}
    return Morris(
        design.label,
        tuple(r.name for r in over),
        design.ts[pick],
        {c: t[:, 0] for c, t in tables.items()},
        {c: t[:, 1] for c, t in tables.items()},
        {c: w[0] for c, w in whole.items()},
        {c: w[1] for c, w in whole.items()},
        {c: w[2] for c, w in whole.items()},
        len(unit),
    )
