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

    def cost(self) -> float:
        """Sum of squares; infinite where a window could not be integrated."""
        return float((self.r**2).sum()) if self.complete.all() else np.inf


def columns(unknowns: Sequence[Unknown]) -> tuple[str, ...]:
    """Slots of the unknowns, each once."""
    return tuple(dict.fromkeys(u.name for u in unknowns))


def spread(lin: Linearisation, unknowns: Sequence[Unknown]) -> np.ndarray:
    """Jacobian by unknown (w, m, u) from that by slot."""
    where = {s: i for i, s in enumerate(lin.slots)}
    out = lin.slots_jac[:, :, [where[u.name] for u in unknowns]].copy()
    for j, u in enumerate(unknowns):
        if u.recording is not None:
            out[lin.recording != u.recording, :, j] = 0.0
    return out
