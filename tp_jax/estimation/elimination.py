"""Window states eliminated: what is left of a linearisation is small.

Per window w the sum of squares, minimised over its own state, is quadratic in the unknowns with
gradient g_w and information matrix H_w.
"""

import dataclasses

import numpy as np

from tp_jax.estimation.normal_equations import NormalEquations


@dataclasses.dataclass(frozen=True)
class Eliminated:
    """Per window: g (w, u) = J'r and H (w, u, u) = J'J after the states are projected out.

    cost: (w,) sum of squares at the minimising states; state_step: (w, 4) the step to them;
    state_gain: (w, 4, u) how they follow the unknowns.
    """

    g: np.ndarray
    H: np.ndarray
    cost: np.ndarray
    state_step: np.ndarray
    state_gain: np.ndarray

    def summed(
        self, pull: np.ndarray | float = 0.0, prior: np.ndarray | None = None
    ) -> NormalEquations:
        """Returns the normal equations of all windows.

        Args:
            pull, prior: (u,) half the gradient of the priors and their information (`priors`).
        """
        prior = np.zeros(self.g.shape[1]) if prior is None else prior
        return NormalEquations(self.g.sum(axis=0) + pull, self.H.sum(axis=0), prior)


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
