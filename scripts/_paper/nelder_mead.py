"""The paper's search: Nelder-Mead on (17) over the eleven numbers as they are.

Scilab's `fminsearch` begins with a simplex of the start and of eleven points beside it, each with
one number five per cent larger, and so does SciPy's.
"""

import time
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from scripts._paper.objective import Objective


class Searched(NamedTuple):
    """End of a search: x (11,), y [rad^2], evaluations of a whole run, seconds, y by
    evaluation (the best so far), what it said."""

    x: np.ndarray
    y: float
    evaluations: int
    seconds: float
    history: list[float]
    message: str


def search(objective: Objective, start, iterations: int) -> Searched:
    """Nelder-Mead from a start.

    Args:
        objective: (17).
        start: (11,) numbers.
        iterations: Listing 1 allows 50, the text speaks of thousands.
    """
    objective = objective.fresh()
    begin = time.perf_counter()
    found = minimize(
        objective,
        np.asarray(start, float),
        method="Nelder-Mead",
        options={"maxiter": iterations, "maxfev": 3 * iterations + 50, "xatol": 0.0, "fatol": 0.0},
    )
    seconds = time.perf_counter() - begin
    best = np.minimum.accumulate(objective.history).tolist()
    return Searched(
        found.x, float(found.fun), objective.evaluations, seconds, best, str(found.message)
    )
