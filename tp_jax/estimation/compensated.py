"""Linear least squares whose regressors are noisy, with the noise's share taken off.

Source: Stoica and Soderstrom (1982), Automatica 18:99.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np
from scipy.optimize import lsq_linear

WEAK = 1e-4  # weight of a prior, in mean squares of the targets: it decides where nothing else does
RANK = 1e-10  # relative eigenvalue below which a direction counts as not told


@dataclasses.dataclass(frozen=True)
class Rows:
    """Rows `target = row @ coefficients` of equations.

    names: (p,) of the coefficients; A: (N, p); b: (N,); noise: (N, p, p + 1) covariance of the
    noise of a row, with the target's in the last column; block: (N,) which second of the data a
    row is of.
    """

    names: tuple[str, ...]
    A: np.ndarray
    b: np.ndarray
    noise: np.ndarray
    block: np.ndarray

    def solve(
        self,
        times: np.ndarray,
        known: Mapping[str, float],
        positive: frozenset[str],
        prior: Mapping[str, tuple[float, float]],
    ) -> dict[str, float]:
        """Coefficients by name.

        Args:
            times: how often each block counts.
            known: coefficients that are held.
            positive: coefficients that are not below zero.
            prior: mean and standard deviation of coefficients that the rows may not tell.
        """
        w = times[self.block]
        H = (self.A * w[:, None]).T @ self.A - np.einsum("n,nij->ij", w, self.noise[:, :, :-1])
        g = self.A.T @ (w * self.b) - w @ self.noise[:, :, -1]
        held = np.array([n in known for n in self.names], bool)
        out = {n: known[n] for n in self.names if n in known}
        if held.all():
            return out
        x = np.array([known[n] for n in self.names if n in known])
        names = [n for n in self.names if n not in known]
        g = g[~held] - H[np.ix_(~held, held)] @ x
        H = H[np.ix_(~held, ~held)]
        unit = WEAK * float(w @ self.b**2) / max(float(w.sum()), 1.0)
        for i, name in enumerate(names):
            mean, sd = prior.get(name, (0.0, np.inf))
            H[i, i] += unit / sd**2
            g[i] += unit * mean / sd**2
        largest = max(float(np.abs(np.diag(H)).max()), 1e-300)
        scale = np.sqrt(np.maximum(np.diag(H), 1e-14 * largest))
        values, vectors = np.linalg.eigh(H / np.outer(scale, scale))
        values = np.maximum(values, RANK * max(values[-1], 1e-300))
        root = np.sqrt(values)[:, None] * vectors.T
        target = (vectors.T @ (g / scale)) / np.sqrt(values)
        low = np.array([0.0 if n in positive else -np.inf for n in names])
        found = lsq_linear(root, target, (low, np.inf), method="bvls").x / scale
        return out | dict(zip(names, found.tolist(), strict=True))

    def misfit(self, times: np.ndarray, x: Mapping[str, float]) -> float:
        """Sum of squares."""
        r = self.b - self.A @ np.array([x[n] for n in self.names])
        return float(times[self.block] @ r**2)
