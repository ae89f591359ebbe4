"""The methods of identification, by the names the command line knows them by."""

import functools

from tp_jax.errors import InputError
from tp_jax.estimation import optimistix_methods, variable_projection
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.ladder import Method, Objective, problem_of, rungs

LEAST_SQUARES, NELDER_MEAD = "least-squares", "nelder-mead"
METHODS = (LEAST_SQUARES, NELDER_MEAD, *optimistix_methods.SOLVERS)
OBJECTIVES: tuple[Objective, ...] = ("windows", "free-run")


def usual_objective(method: str) -> Objective:
    """What a method minimises unless told otherwise."""
    return "free-run" if method == NELDER_MEAD else "windows"


def fitter(name: str, setting: Setting, objective: Objective) -> Method:
    """The function that fits unknowns and window states; see `variable_projection.fit`.

    For `nelder-mead`, which does not, the one that judges what it found.
    """
    if name in (LEAST_SQUARES, NELDER_MEAD):
        return variable_projection.fit
    blocks = max(len(problem_of(setting, r).blocks()) for r in rungs(setting, objective))
    return functools.partial(optimistix_methods.fit, method=name, blocks=blocks)


def check(method: str, objective: Objective) -> None:
    """InputError where there is no such method, or not on this objective."""
    if method not in METHODS:
        raise InputError(f"There is no method {method!r}, choose one of: {', '.join(METHODS)}.")
    if objective not in OBJECTIVES:
        raise InputError(
            f"There is no objective {objective!r}, choose one of: {', '.join(OBJECTIVES)}."
        )
    if method == NELDER_MEAD and objective != "free-run":
        raise InputError(
            "Method nelder-mead has no way to take the windows' states along; choose objective "
            "free-run, or another method."
        )
