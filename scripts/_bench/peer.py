"""Definition of a peer: a name and up to three functions, all of the same arguments and results."""

import os
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

#: (parameters, eps, ts, tol) -> result
Solver = Callable[[np.ndarray, float, np.ndarray, float], np.ndarray]


class Peer(NamedTuple):
    """One way to compute the same motions.

    A first call may compile or build what the peer keeps for such arguments; it is never timed.
    Results are NumPy arrays, ready when the function returns. What fails is NaN.

    Attributes:
        name: as in the table.
        run: parameters (11,), eps [s], ts (n,) [s], tolerance -> angles (n, 2) [rad].
        sweep: parameters (lanes, 11), otherwise as `run` -> (lanes, n, 2); on all cores.
        sensitivities: arguments of `run` -> derivatives (n, 2, 14) of the angles, columns as in
            `problem.DIRECTIONS`; None where a user would have to write them.
        threads: how many threads or processes `sweep` uses; one run uses one.
    """

    name: str
    run: Solver
    sweep: Solver
    sensitivities: Solver | None = None
    threads: int = 1


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
