"""Is there any structure left? One test for the whole catalogue, calibrated on the data itself.

For every effect the efficient scores of the blocks are summed and studentised with their own
scatter. Under "no effect" the blocks' signs are arbitrary; flipping them at random (the wild
cluster bootstrap of Cameron, Gelbach and Miller, 2008, Rev. Econ. Stat. 90) gives the
distribution of the largest statistic of all effects, with their correlations and the small number
of blocks taken as they are.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy import stats

from tp_jax.gap.screen import Scored

DRAWS = 4000


@dataclasses.dataclass(frozen=True)
class Structure:
    """p: of the largest statistic of all; by_effect: family-wise p of each scored variant."""

    p: float
    by_variant: np.ndarray
    draws: int


def structure_test(scored: Sequence[Scored], seed: int) -> Structure:
    """Family-wise test that no effect of the catalogue is present.

    Args:
        scored: of `Screen.scored`.
        seed: of the random signs.
    """
    if not scored:
        return Structure(1.0, np.ones(0), 0)
    rng = np.random.default_rng(seed)
    n_blocks = scored[0].blocks.shape[0]
    signs = rng.integers(0, 2, size=(DRAWS, n_blocks)) * 2.0 - 1.0
    observed = np.zeros(len(scored))
    largest = np.zeros(DRAWS)
    for i, s in enumerate(scored):
        observed[i] = _as_normal(_studentised(s.blocks, np.ones((1, n_blocks))), s.blocks)[0]
        drawn = _as_normal(_studentised(s.blocks, signs), s.blocks)
        largest = np.maximum(largest, drawn)
    p = (1.0 + (largest[None, :] >= observed[:, None]).sum(axis=1)) / (DRAWS + 1.0)
    return Structure(float(p.min()), p, DRAWS)


def _studentised(blocks: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """Hotelling's statistic of the sum of signed block scores, (draws,)."""
    n, _ = blocks.shape
    scale = np.sqrt((blocks**2).mean(axis=0))
    x = blocks[:, scale > 0] / scale[scale > 0]
    q = x.shape[1]
    if q == 0 or n <= q + 1:
        return np.zeros(signs.shape[0])
    total = signs @ x  # (draws, q)
    second = x.T @ x  # does not depend on the signs
    inverse = np.linalg.pinv(second, rcond=1e-9, hermitian=True)
    u = np.einsum("dq,qr,dr->d", total, inverse, total)
    return np.clip(u, 0.0, None)


def _as_normal(u: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Puts effects with different numbers of amplitudes on one scale (a chi-square quantile)."""
    n, q = blocks.shape[0], int((np.abs(blocks).max(axis=0) > 0).sum())
    if q == 0 or n <= q + 1:
        return np.zeros_like(u)
    # u <= n; the score form n u / (n - u) is Hotelling's T^2 with the mean taken out.
    t2 = u / np.maximum(1.0 - u / n, 1e-12) * (n - 1.0) / n
    logp = stats.f.logsf(t2 * (n - q) / (q * (n - 1.0)), q, n - q)
    return -logp
