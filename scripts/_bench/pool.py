"""Processes for the sweeps of peers that hold Python's lock while they integrate.

Started on first use and kept, so that no start is timed. Fresh processes rather than forks: a fork
of a process with threads, as JAX has them, may hang.
"""

import atexit
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from importlib import import_module

import numpy as np

from .peer import Solver, cores


@cache
def workers() -> ProcessPoolExecutor:
    """Starts as many processes as cores."""
    pool = ProcessPoolExecutor(cores(), multiprocessing.get_context("spawn"))
    atexit.register(pool.shutdown)
    return pool


def one(module: str, function: str, *arguments: object) -> np.ndarray:
    """Calls `module.function`, by name so that no closure has to travel to another process."""
    return getattr(import_module(module), function)(*arguments)


def sweep_of(module: str, function: str = "run") -> Solver:
    """A sweep by processes, each row a `module.function(row, eps, ts, tol)`."""

    def sweep(table: np.ndarray, eps: float, ts: np.ndarray, tol: float) -> np.ndarray:
        rows = len(table)
        fixed = [[value] * rows for value in (module, function)]
        rest = [[value] * rows for value in (eps, ts, tol)]
        # small chunks, since runs differ in length
        chunk = max(1, min(8, rows // (4 * cores())))
        return np.stack(list(workers().map(one, *fixed, table, *rest, chunksize=chunk)))

    return sweep
