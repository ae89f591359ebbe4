"""A fit in parts: some windows at a time, where the derivatives of all would fill the memory.

Sums over windows are all that a screen or a test takes from derivatives by sample, and these sums
are small.
"""

import dataclasses
from collections.abc import Iterator

import numpy as np

from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.window_states import of_windows

#: Derivatives at a time: 128 MB. An array of derivatives has some copies for a moment.
AT_ONCE = 16_000_000


def parts(fit: Fit, columns: int, at_once: int = AT_ONCE) -> Iterator[tuple[np.ndarray, Fit]]:
    """A fit by parts of its windows, in order; as it is where one part holds all.

    Args:
        fit: at its optimum.
        columns: how many derivatives of each row are looked at.
        at_once: how many numbers a part may have, if it has more than one window.

    Yields:
        the windows (k,) of a part, and the fit there.
    """
    windows, rows = fit.linearisation.r.shape
    each = max(at_once // max(rows * columns, 1), 1)
    if each >= windows:
        yield np.arange(windows), fit
        return
    many = -(-windows // each)
    for which in np.array_split(np.arange(windows), many):
        yield which, some_of(fit, which)


def some_of(fit: Fit, which: np.ndarray) -> Fit:
    """A fit at some of its windows.

    Its numbers stay those of the whole, and so do its sum of squares and what was eliminated: of a
    part, ask the linearisation.
    """
    problem = of_windows(fit.problem, which)
    lin = of_some(fit.linearisation, which, int(problem.windows.count.max()))
    return dataclasses.replace(fit, problem=problem, states=fit.states[which], linearisation=lin)


def rows_of(lin: Linearisation, count: int) -> np.ndarray:
    """Rows of windows that are padded to `count` samples only."""
    n = lin.n_samples
    return np.r_[: 2 * count, 2 * n : 2 * n + 4]


def of_some(lin: Linearisation, which: np.ndarray, count: int) -> Linearisation:
    """The linearisation of some windows, padded to `count` samples."""
    rows = rows_of(lin, count)

    def cut(rows_first: np.ndarray) -> np.ndarray:
        return rows_first[np.ix_(which, rows)]

    return dataclasses.replace(
        lin,
        r=cut(lin.r),
        states_jac=cut(lin.states_jac),
        slots_jac=cut(lin.slots_jac),
        valid=cut(lin.valid),
        states=lin.states[which, :count],
        complete=lin.complete[which],
        recording=lin.recording[which],
        own=None if lin.own is None else lin.own[which],
        raw=None if lin.raw is None else lin.raw[which, : 2 * count],
    )
