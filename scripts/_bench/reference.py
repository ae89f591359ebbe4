"""Reference for errors: LSODA at a tight tolerance, cross-checked by another method.

Kept between runs in the user's cache folder, under a name made of all that goes in.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tp_jax._config import cache_folder

from . import equations, variational
from .peers import scipy_lsoda, scipy_radau

EDITION = 1
"""Number to be raised when a reference would come out differently."""

FEW = 8
"""Fewer rows are not worth starting processes for, nor compiling a second method."""


def angles(table: np.ndarray, eps: float, ts: np.ndarray, tol: float) -> np.ndarray:
    """Angles (lanes, n, 2) of the rows of `table`."""

    def solve(*args):
        if len(table) < FEW:
            return np.stack([scipy_lsoda.run(row, *args[1:]) for row in args[0]])
        return scipy_lsoda.make().sweep(*args)

    return _kept("angles", solve, table, eps, ts, tol)


def agreement(table: np.ndarray, eps: float, ts: np.ndarray, tol: float) -> tuple[str, float]:
    """Name of a second method, and by how much [rad] its angles differ from `angles` at most.

    Numba's explicit method on all rows where Numba is installed; otherwise, or where there are few,
    Radau on the first row.
    """
    if equations.numba is not None and len(table) >= FEW:
        from .peers import numba_dopri5

        name, rows, solve = "numba-dopri5", table, numba_dopri5.sweep
        second = _kept("second", solve, rows, eps, ts, tol)
    else:
        name, rows = "scipy-radau", table[:1]
        second = scipy_radau.run(rows[0], eps, ts, 100.0 * tol)[None]
    return name, float(np.abs(second - angles(table, eps, ts, tol)[: len(rows)]).max())


def sensitivities(row: np.ndarray, eps: float, ts: np.ndarray, tol: float) -> np.ndarray:
    """Derivatives (n, 2, 14) of the angles, columns as in `problem.DIRECTIONS`."""
    return _kept("sensitivities", variational.by_lsoda, row, eps, ts, tol)


def _kept(kind: str, solve: Callable, row: np.ndarray, eps: float, ts, tol: float) -> np.ndarray:
    """`solve(row, eps, ts, tol)`, from the cache folder where it is there."""
    mark = hashlib.sha256(f"{EDITION} {kind} {eps!r} {tol!r} {row.shape}".encode())
    mark.update(np.ascontiguousarray(row).tobytes() + ts.tobytes())
    path: Path = cache_folder().parent / "bench" / f"{kind}-{mark.hexdigest()[:24]}.npz"
    try:
        with np.load(path) as file:
            return file["values"]
    except (OSError, KeyError, ValueError):
        values = solve(row, eps, ts, tol)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part.npz")
        np.savez(part, values=values)
        part.replace(path)
    except OSError:
        pass  # nowhere to keep it: then it is computed anew next time
    return values
