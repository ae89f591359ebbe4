"""The methods of identification, by the names the command line knows them by."""

import functools

from tp_jax.errors import InputError
from tp_jax.estimation import optimistix_methods, variable_projection
from tp_jax.estimation.optimistix_methods import SOLVER_KINDS, Solver
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.schedule import PATIENCE, Method, Objective, problem_of, rungs

LEAST_SQUARES, NELDER_MEAD = "least-squares", "nelder-mead"
METHODS = (LEAST_SQUARES, NELDER_MEAD, *optimistix_methods.SOLVERS)
AT_MOST = 1000  # evaluations in a run of a solver of one's own, which has its own way to end
OBJECTIVES: tuple[Objective, ...] = ("windows", "free-run")


def usual_objective(method: str | Solver) -> Objective:
    """Returns what a method minimises unless another objective is asked for."""
    return "free-run" if method == NELDER_MEAD else "windows"


def fitter(name: str | Solver, setting: PreparedCampaign, objective: Objective) -> Method:
    """The function that fits unknowns and window states; see `variable_projection.fit`.

    For `nelder-mead`, which does not, the one that judges what it found.

    Args:
        name: in `METHODS`, or a solver of optimistix.
        setting: what is fitted. objective: what is minimised.
    """
    if name in (LEAST_SQUARES, NELDER_MEAD):
        return functools.partial(variable_projection.fit, kinks=True, max_iterations=PATIENCE)
    solver = optimistix_methods.SOLVERS[name] if isinstance(name, str) else name
    blocks = max(len(problem_of(setting, r).blocks()) for r in rungs(setting, objective))
    known = isinstance(name, str)
    evaluations = optimistix_methods.EVALUATIONS if known else AT_MOST
    return functools.partial(
        optimistix_methods.fit, solver=solver, blocks=blocks, evaluations=evaluations, ends=known
    )


def name_of(method: str | Solver) -> str:
    """A method's name in results: that of its class for a solver of one's own."""
    return method if isinstance(method, str) else type(method).__name__


def described(method: str | Solver) -> str:
    """All that makes a method what it is: starts by one are not resumed by another."""
    return method if isinstance(method, str) else repr(method)


def check(method: str | Solver, objective: Objective) -> None:
    """InputError where there is no such method, or not on this objective."""
    if not isinstance(method, (str, *SOLVER_KINDS)):
        raise InputError(
            f"A method is one of {', '.join(METHODS)}, or a least-squares solver or minimiser of "
            f"optimistix, not {method!r}."
        )
    if isinstance(method, str) and method not in METHODS:
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
