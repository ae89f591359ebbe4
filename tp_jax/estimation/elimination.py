"""Window states eliminated: what is left of a linearisation is small.

Per window w the sum of squares, minimised over its own state, is quadratic in the unknowns with
gradient g_w and information matrix H_w.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.linearisation import Linearisation, columns, gathered, places
from tp_jax.estimation.normal_equations import NormalEquations


@dataclasses.dataclass(frozen=True)
class Eliminated:
    """Per window: g (w, d) = J'r and H (w, d, d) = J'J after the states are projected out.

    cost: (w,) sum of squares at the minimising states; state_step: (w, 4) the step to them;
    state_gain: (w, 4, d) how they follow the columns; to: (w, d) which unknown each column is of
    (`places`); size: how many unknowns there are, where columns are not the unknowns themselves.
    """

    g: np.ndarray
    H: np.ndarray
    cost: np.ndarray
    state_step: np.ndarray
    state_gain: np.ndarray
    to: np.ndarray | None = None
    size: int | None = None

    def summed(
        self, pull: np.ndarray | float = 0.0, prior: np.ndarray | None = None
    ) -> NormalEquations:
        """Returns the normal equations of all windows.

        Args:
            pull, prior: (u,) half the gradient of the priors and their information (`priors`).
        """
        g, H = self.sums(np.zeros(len(self.g), dtype=int))
        prior = np.zeros(g.shape[1]) if prior is None else prior
        return NormalEquations(g[0] + pull, H[0], prior)

    def sums(self, group: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gradients (G, u) and information (G, u, u) of groups of windows, by unknown.

        Args:
            group: of each window (w,), from 0 on.
        """
        many = int(group.max(initial=-1)) + 1
        to, size = self._places()
        return (
            np.stack([gathered(self.g[group == k], to[group == k], size) for k in range(many)]),
            np.stack([gathered(self.H[group == k], to[group == k], size) for k in range(many)]),
        )

    def following(self, step: np.ndarray) -> np.ndarray:
        """Moves (w, 4) of the window states, to their minimum where the unknowns move (u,) too."""
        own = self.own(step[None])[..., None]
        return self.state_step + (self.state_gain @ own)[..., 0]

    def own(self, numbers: np.ndarray) -> np.ndarray:
        """Numbers (w, d) of each window's columns, from those of the unknowns (w or 1, u)."""
        to, _ = self._places()
        rows = np.broadcast_to(numbers, (len(to), numbers.shape[1]))
        return np.where(to >= 0, np.take_along_axis(rows, np.maximum(to, 0), axis=1), 0.0)

    def gain_by_unknown(self) -> np.ndarray:
        """(w, 4, u) how the states follow the unknowns."""
        to, size = self._places()
        out = np.zeros((*self.state_gain.shape[:2], size))
        window, column = np.nonzero(to >= 0)
        out[window, :, to[window, column]] = self.state_gain[window, :, column]
        return out

    def _places(self) -> tuple[np.ndarray, int]:
        if self.to is not None and self.size is not None:
            return self.to, self.size
        columns = self.g.shape[1]
        return np.broadcast_to(np.arange(columns), self.g.shape), columns


def eliminated(
    lin: Linearisation,
    unknowns: Sequence[Unknown],
    slope: np.ndarray | None = None,
    *,
    damping: float = 0.0,
    kinked: np.ndarray | None = None,
) -> Eliminated:
    """Projects the window states out of a linearisation by unknowns.

    Args:
        lin: of some windows, with the unknowns' slots.
        unknowns: (u,) of the fit.
        slope: (u,) of the unknowns by their coordinates; one if None.
        damping, kinked: see `eliminate`.
    """
    slots = columns(unknowns)
    to = places(unknowns, slots, lin.recording)
    jac = lin.by_slot(slots)
    if slope is not None and slope.size:
        jac *= np.where(to >= 0, slope[to], 1.0)[:, None, :]
    out = eliminate(lin.r, lin.states_jac, jac, damping, kinked)
    return dataclasses.replace(out, to=to, size=len(unknowns))


def eliminate(
    r: np.ndarray,
    states_jac: np.ndarray,
    jac: np.ndarray,
    damping: float = 0.0,
    kinked: np.ndarray | None = None,
) -> Eliminated:
    """Projects the window states out.

    Args:
        r: (w, m) residuals. states_jac: (w, m, 4). jac: (w, m, u).
        damping: relative Levenberg-Marquardt damping of the states.
        kinked: (w,) bool, windows whose state lies in a kink of their sum of squares. It cannot
            go down the slope that it still has, so it follows the unknowns along the kink alone,
            where the slope is zero.
    """
    xt = states_jac.transpose(0, 2, 1)
    hxx = xt @ states_jac
    gx = (xt @ r[:, :, None])[..., 0]
    hxu = xt @ jac
    ut = jac.transpose(0, 2, 1)
    huu = ut @ jac
    gu = (ut @ r[:, :, None])[..., 0]
    diagonal = np.einsum("wii->wi", hxx)
    largest = diagonal.max(axis=1, keepdims=True)
    # A window that says nothing (it could not be integrated) keeps its state where it is.
    floor = np.where(largest > 0.0, 1e-12 * largest, 1.0)
    hxx = hxx + (damping * diagonal + floor)[:, :, None] * np.eye(hxx.shape[1])
    solved = np.linalg.solve(hxx, np.concatenate([gx[..., None], hxu], axis=2))
    step, gain = -solved[..., 0], -solved[..., 1:]
    if kinked is not None and kinked.any():
        promise = -np.einsum("wx,wx->w", gx, step)
        across = np.einsum("wx,wxu->wu", step, hxu) / np.maximum(promise, 1e-300)[:, None]
        held = gain + step[:, :, None] * across[:, None, :]  # then gx'held is zero
        gain = np.where(kinked[:, None, None], held, gain)
        step = np.where(kinked[:, None], 0.0, step)
    g = gu + np.einsum("wxu,wx->wu", hxu, step)
    H = huu + hxu.transpose(0, 2, 1) @ gain
    cost = (r**2).sum(axis=1) + np.einsum("wx,wx->w", gx, step)
    return Eliminated(g, 0.5 * (H + H.transpose(0, 2, 1)), cost, step, gain)
