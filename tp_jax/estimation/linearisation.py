"""Residuals of all windows and their derivatives, and columns of them by unknown."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.layout import Unknown


@dataclasses.dataclass
class Linearisation:
    """Weighted residuals of all windows and their derivatives.

    r: (w, m) residuals in units of the noise, padded with zeros; rows are samples x channels, then
    four of the prior. Where the noise is coloured its correlation is taken out of r and of all
    derivatives (`Colour.whiten`), and raw (w, m - 4) has the residuals before that. states_jac:
    (w, m, 4). slots_jac: (w, m, d), by slot in `slots` (the same slot of different recordings is
    one column here). valid: (w, m) bool. states: (w, n, 4). complete: (w,). own: (w, k) effects'
    own states at the windows' ends, where it was asked for no slots.
    """

    r: np.ndarray
    states_jac: np.ndarray
    slots_jac: np.ndarray
    valid: np.ndarray
    states: np.ndarray
    complete: np.ndarray
    slots: tuple[str, ...]
    recording: np.ndarray
    own: np.ndarray | None = None
    raw: np.ndarray | None = None

    @property
    def samples(self) -> np.ndarray:
        """(w, m - 4) residuals of the samples in units of the noise, as they were read."""
        return self.r[:, :-4] if self.raw is None else self.raw

    @property
    def n_samples(self) -> int:
        """Samples of the windows' rows (per channel)."""
        return (self.r.shape[1] - 4) // 2

    def by_slot(self, slots: Sequence[str]) -> np.ndarray:
        """Derivatives (w, m, d) by some of the slots; a copy."""
        where = {s: i for i, s in enumerate(self.slots)}
        return self.slots_jac[:, :, [where[s] for s in slots]]

    def cost(self) -> float:
        """Sum of squares; infinite where a window could not be integrated."""
        return float((self.r**2).sum()) if self.complete.all() else np.inf


def columns(unknowns: Sequence[Unknown]) -> tuple[str, ...]:
    """Slots of the unknowns, each once."""
    return tuple(dict.fromkeys(u.name for u in unknowns))


def spread(lin: Linearisation, unknowns: Sequence[Unknown]) -> np.ndarray:
    """Jacobian by unknown (w, m, u) from that by slot."""
    out = lin.by_slot([u.name for u in unknowns])
    for j, u in enumerate(unknowns):
        if u.recording is not None:
            out[lin.recording != u.recording, :, j] = 0.0
    return out


def places(unknowns: Sequence[Unknown], slots: Sequence[str], recording: np.ndarray) -> np.ndarray:
    """Positions (w, d) of each window's columns among the unknowns, -1 for a column of none.

    A slot with a number for each recording is one column of a window but many unknowns. Windows
    that are kept by slot need memory in proportion to the recordings; spread by unknown, to its
    square.

    Args:
        unknowns: of the fit.
        slots: (d,) of the columns.
        recording: (w,) of each window.
    """
    most = max([int(recording.max(initial=-1)), *(u.recording or 0 for u in unknowns)])
    table = np.full((most + 1, len(slots)), -1)
    column = {s: j for j, s in enumerate(slots)}
    for i, u in enumerate(unknowns):
        table[slice(None) if u.recording is None else u.recording, column[u.name]] = i
    return table[recording]


def gathered(parts: np.ndarray, to: np.ndarray, size: int) -> np.ndarray:
    """Sum over windows, by unknown: (size,) of vectors (w, d), (size, size) of matrices (w, d, d).

    Args:
        parts: of each window, by column. to: (w, d) as of `places`. size: number of unknowns.
    """
    out = np.zeros((size,) * (parts.ndim - 1))
    rows, which = np.unique(to, axis=0, return_inverse=True)
    for i, row in enumerate(rows):
        there = np.flatnonzero(row >= 0)
        total = parts[which.ravel() == i].sum(axis=0)
        at = np.ix_(*(row[there],) * total.ndim)
        out[at] += total[np.ix_(*(there,) * total.ndim)]
    return out
