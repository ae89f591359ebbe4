"""Gradients on the same objective: least squares of the whole free run.

The residuals are those of (17), the derivatives exact; what is free is what can be known (B1 held,
Ts2 left out), in logarithms, so that nothing turns negative. Over a few slow periods this is quick
and exact. Where a rider slips many times in a recording, a small error of a parameter shifts the
first slip and everything after it, and the search ends in the nearest of many minima.
"""

import time

import numpy as np
from scipy.optimize import least_squares

from scripts._paper.nelder_mead import Searched
from scripts._paper.objective import MAX_STEPS, ORDER, TOLERANCE, Objective
from tp_jax.identifiability.design import PLACES
from tp_jax.model import presets
from tp_jax.model.parameters import PAPER_EPS
from tp_jax.model.pendulum import PRINTED_REACTION
from tp_jax.simulation.sensitivities import sensitivities

FREE = tuple(n for n in ORDER if n not in ("B1", "Ts2"))
WIDEST = np.log(1e3)  # of a parameter about its start


def search(objective: Objective, start, evaluations: int) -> Searched:
    """Trust-region least squares on the free run from a start (11,)."""
    objective = objective.fresh()
    start = np.asarray(start, float)
    where = [ORDER.index(n) for n in FREE]
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def at(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = u.tobytes()
        if key not in known:
            known.clear()
            x = start.copy()
            x[where] = start[where] * np.exp(u)
            model = presets.double_pendulum(
                **dict(zip(ORDER, x.tolist(), strict=True)),
                omega=objective.omega,
                eps=PAPER_EPS,
                reaction=PRINTED_REACTION,
            )
            found = sensitivities(
                model,
                objective.ts,
                by=[PLACES[n] for n in FREE],
                tolerance=TOLERANCE,
                max_steps=MAX_STEPS,
            )
            objective.evaluations += 1
            objective.history.append(objective.of(found.motion))
            residual = np.concatenate(
                [found.motion.phi1 - objective.phi1, found.motion.phi2 - objective.phi2]
            )
            slope = np.concatenate([found.phi1[:, 4:], found.phi2[:, 4:]]) * x[where]
            # a run that cannot be followed is no place to stay
            known[key] = (
                np.nan_to_num(residual, nan=1e6, posinf=1e6, neginf=-1e6),
                np.nan_to_num(slope, nan=0.0, posinf=0.0, neginf=0.0),
            )
        return known[key]

    begin = time.perf_counter()
    found = least_squares(
        lambda u: at(u)[0],
        np.zeros(len(FREE)),
        jac=lambda u: at(u)[1],
        bounds=(-WIDEST, WIDEST),
        max_nfev=evaluations,
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-14,
    )
    seconds = time.perf_counter() - begin
    x = start.copy()
    x[where] = start[where] * np.exp(found.x)
    y = objective.of_x(x)
    best = np.minimum.accumulate(objective.history).tolist()
    return Searched(x, y, objective.evaluations, seconds, best, str(found.message))
