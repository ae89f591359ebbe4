"""Scores of readings that are rounded more coarsely than they are noisy.

The error of such a reading follows from the motion, and comes again where the motion does: it is
not independent from block to block, and an effect may well resemble it. So what rounding does to
the scores is drawn: the readings that the fit predicts are given noise, moved by some part of a
step (where the steps lie is not known to a part of one), and rounded. What it does to the sum of
squares is drawn alike: a body that comes to rest in the middle of a step reads without any error,
and one at its edge with half a step's.
"""

import dataclasses

import numpy as np

from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.noise_levels import CHANNELS
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.recordings.noise import quantum, steps_hide

AT_ONCE = 25  # draws
LEAST_NOISE = 0.05  # steps: of a sensor whose noise rounding hides altogether


@dataclasses.dataclass(frozen=True)
class Rounding:
    """Source of drawn scores of readings that are rounded.

    Attributes:
        problem: of the fit.
        predicted: (w, n, 2) readings as the fit has them [rad].
        step: (w, 2) of the readings [rad], 0 where noise hides them.
        columns: (w, m, k) derivatives, window states projected out.
        block: (w,) of each window.
    """

    problem: Problem
    predicted: np.ndarray
    step: np.ndarray
    columns: np.ndarray
    block: np.ndarray

    def scores(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Scores (B, k, count) by block of so many draws."""
        parts = [min(AT_ONCE, count - i) for i in range(0, count, AT_ONCE)]
        return np.concatenate([self._scores(rng, n) for n in parts], axis=2)

    def _scores(self, rng: np.random.Generator, count: int) -> np.ndarray:
        of_window = self.columns.transpose(0, 2, 1) @ self.errors(rng, count)
        out = np.zeros((self.block.max() + 1, *of_window.shape[1:]))
        np.add.at(out, self.block, of_window)
        return out

    def errors(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """Whitened errors (w, m, count) of so many draws."""
        windows, samples, _ = self.predicted.shape
        # single precision: half the time, and draws need no more
        r = rng.standard_normal((windows, 2 * samples + 4, count), dtype=np.float32)
        rounded = r.copy()
        by_sample = rounded[:, :-4].reshape(windows, samples, 2, count)
        sigma = self.problem.sigma
        for c in range(2):
            mine = np.flatnonzero(self.step[:, c] > 0.0)
            if not mine.size:
                continue
            step = self.step[mine, c, None, None]
            inner = _beneath(sigma[mine, c], self.step[mine, c])
            recording = self.problem.windows.recording[mine]
            _, which = np.unique(recording, return_inverse=True)
            moved = step * rng.random((which.max() + 1, 1, count))[which]
            true = self.predicted[mine, :, c, None]
            read = true + inner[:, None, None] * by_sample[mine, :, c] + moved
            by_sample[mine, :, c] = (true + moved - step * np.round(read / step)) / sigma[
                mine, c, None, None
            ]
        self.problem.whiten(rounded)
        coarse = np.repeat(self.step[:, None] > 0.0, samples, axis=1).reshape(windows, -1)
        r[:, :-4] = np.where(coarse[:, :, None], rounded[:, :-4], r[:, :-4])
        return r


def drawn_squares(fit: Fit, setting: PreparedCampaign, count: int, seed: int = 0) -> np.ndarray:
    """Draws what a fit's sum of squares per degree of freedom is under noise and rounding (count,).

    None (0,) where noise hides all steps. The windows' states follow the errors; that the unknowns
    do too is left to the degrees of freedom.

    Args:
        fit, setting: see `rounding`. count: draws.
    """
    steps = coarse_steps(setting)
    if not steps.any():
        return np.zeros(0)
    lin = fit.linearisation
    w = fit.problem.windows.n
    nothing = np.zeros((w, lin.r.shape[1], 0), dtype=np.float32)
    source = rounding(fit, setting, steps, nothing, np.zeros(w, dtype=int))
    assert source is not None
    rng = np.random.default_rng(seed)
    out: list[float] = []
    while len(out) < count:
        r = source.errors(rng, min(AT_ONCE, count - len(out))) * lin.valid[:, :, None]
        r += lin.states_jac @ eliminate(lin.r, lin.states_jac, r).state_gain
        out += (r[:, :-4] ** 2).sum(axis=(0, 1)).tolist()
    return np.array(out) / max(fit.dof, 1)


def _beneath(sigma: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Noise [rad] before rounding, of which the level has both."""
    return np.sqrt(np.maximum(sigma**2 - step**2 / 12.0, (LEAST_NOISE * step) ** 2))


def coarse_steps(setting: PreparedCampaign) -> np.ndarray:
    """Steps (recordings, 2) of readings that hide their noise [rad], zero for others."""
    steps = np.zeros((len(setting.recordings), 2))
    for i in setting.fitted:
        for c, name in enumerate(CHANNELS):
            readings = setting.recordings[i].channels.get(name)
            if readings is not None and steps_hide(readings, setting.levels[i, c]):
                steps[i, c] = quantum(readings)
    return steps


def rounding(
    fit: Fit,
    setting: PreparedCampaign,
    steps: np.ndarray,
    columns: np.ndarray | None,
    block: np.ndarray,
) -> Rounding | None:
    """Makes what draws the scores of a fit's readings; None where noise hides all their steps.

    Args:
        fit: to the campaign. setting: the campaign. steps: as of `coarse_steps`.
        columns: (w, m, k) derivatives of which scores are wanted, window states projected out;
            None where there are no steps.
        block: (w,) of each window.
    """
    if columns is None:
        return None
    w, lin = fit.problem.windows, fit.linearisation
    residual = lin.samples.reshape(w.n, -1, 2) * fit.problem.sigma[:, None]
    at = w.first[:, None] + np.minimum(np.arange(residual.shape[1]), w.count[:, None] - 1)
    data = np.stack([setting.prepared[r].y[rows] for r, rows in zip(w.recording, at, strict=True)])
    return Rounding(fit.problem, data + residual, steps[w.recording], columns, block)
