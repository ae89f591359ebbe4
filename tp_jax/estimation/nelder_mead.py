"""The paper's way: Nelder-Mead on the free-run objective (17).

It ends in local minima from all but the nearest starts; it is here to be compared with.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.free_objective import FreeRunObjective
from tp_jax.estimation.layout import Values
from tp_jax.estimation.least_squares import parameter

ITERATIONS = 50  # as in Listing 1 of the paper


def free_run_search(
    setting: Setting, start: Values, progress: Callable[[str, float | None], None]
) -> tuple[Values, float, int, str]:
    """Searches the baseline's unknowns with SciPy's Nelder-Mead from `start`.

    Returns:
        The values found, the objective (17) [rad^2] there, its evaluations, and SciPy's message.
    """
    problem = setting.problem(setting.horizons[-1])
    unknowns = setting.unknowns()
    specs = [parameter(problem, u) for u in unknowns]
    objective = FreeRunObjective(setting)
    steps = 0

    limits = np.array([setting.bounds.get(s.name, (s.lower, s.upper)) for s in specs]).T

    def values_at(u: np.ndarray) -> Values:
        x = [float(s.from_coordinate(v)) for s, v in zip(specs, u, strict=True)]
        return start.put(unknowns, np.clip(x, *limits))

    def count(_: np.ndarray) -> None:
        nonlocal steps
        steps += 1
        progress("Nelder-Mead on free runs", steps / ITERATIONS)

    u0 = [float(s.to_coordinate(v)) for s, v in zip(specs, start.pick(unknowns), strict=True)]
    found = minimize(
        lambda u: objective(values_at(u)), np.array(u0), method="Nelder-Mead", callback=count,
        options={"maxiter": ITERATIONS},
    )  # fmt: skip
    return values_at(found.x), float(found.fun), int(found.nfev), str(found.message)
