"""Is there any structure left? One test for the whole catalogue, calibrated by simulation.

For every effect the efficient scores s_b of the blocks are summed; the statistic is

    F = s' V^-1 s / (q phi),   phi = mean over blocks of s_b' V_b^-1 s_b / rank V_b,

s = sum of s_b, V_b the information of a block. Under "no effect" the s_b are independent normals
of covariance phi V_b. phi is estimated, from how much the blocks say beyond the noise: noise that
is not quite white, or not quite of the size that was taken, makes it larger and nothing
significant. Blocks count by what they can tell and not by what they happen to say, and an effect
that few blocks tell anything of (where runs begin) is lent the phi that is usual, so it is found
too; signs flipped at random (Cameron, Gelbach and Miller, 2008, Rev. Econ. Stat. 90) have no power
there. What the fit's own unknowns took of the blocks' scatter is taken off the drawn scores too:
with few blocks that is much of it.

The distribution of the largest F of all effects comes from normal scores with the blocks' joint
covariances, whatever number of blocks there is and however effects resemble each other. Where the
readings' steps hide their noise, scores are drawn with the rounding (`rounding`).
"""

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from tp_jax import _tails as tails
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.policy import POLICY
from tp_jax.gap.screen import Screen

DRAWS = 2000
OF_ROUNDING = 250  # draws: each goes over all samples
CHUNK = 250  # draws at a time at most
NUMBERS = 30_000_000  # of scores at a time: 240 MB
LENT = 20  # what the other effects say of phi counts as much as so many blocks
LEAST = 1e-300  # p: a logarithm of less there is none
TELLING = 1e-3  # of the mean block's information: a block with less says nothing of an effect


@dataclasses.dataclass(frozen=True)
class Structure:
    """p: of the largest statistic of all; by_variant: family-wise p of each scored variant."""

    p: float
    by_variant: np.ndarray
    draws: int


def structure_test(seen: Screen, seed: int) -> Structure:
    """Family-wise test that no effect of the catalogue is present.

    Args:
        seen: what a screen found.
        seed: of the simulated scores.
    """
    if not seen.scored:
        return Structure(1.0, np.ones(0), 0)
    blocks, forms = _observed(seen)
    most = np.inf if seen.rounding is None else POLICY.structure.rounding
    observed = _statistics(blocks[:, :, None], forms, most)[:, 0]
    largest = np.concatenate(
        [_statistics(drawn, forms, most).max(axis=0) for drawn in scores_of_noise(seen, seed)]
    )
    p = (1.0 + (largest[None, :] >= observed[:, None]).sum(axis=1)) / (largest.size + 1.0)
    return Structure(float(p.min()), p, largest.size)


def scores_of_noise(seen: Screen, seed: int) -> Iterator[np.ndarray]:
    """Scores (B, E, n) by block that noise alone would give, after the fit: `DRAWS` in all.

    Args:
        seen: what a screen found. With coarse readings there are `OF_ROUNDING` draws.
        seed: of the draws.
    """
    root = roots(seen.by_block.H)
    rng = np.random.default_rng(seed)
    left = DRAWS if seen.rounding is None else OF_ROUNDING
    many = max(len(root) * max(len(seen.information), 1), 1)
    while left:
        count = min(left, CHUNK, max(NUMBERS // many, 1))
        left -= count
        yield _drawn(root, seen, rng, count)


def _drawn(root: np.ndarray, seen: Screen, rng: np.random.Generator, count: int) -> np.ndarray:
    """Scores (B, E, count) of noise alone, after the unknowns have been fitted to it."""
    known = seen.by_block
    own = root @ rng.standard_normal((*root.shape[:2], count))
    if seen.rounding is not None:  # but for what a calibration's error does to them
        drawn = seen.rounding.scores(rng, count)
        rest = np.zeros((len(own) - len(drawn), *own.shape[1:]))
        own[: len(drawn)] = known.own_scores(np.concatenate([drawn, rest]))[: len(drawn)]
    return known.scores(known.after_the_fit(own, seen.covariance))


def roots(V: np.ndarray) -> np.ndarray:
    """Matrices (B, E, E) whose squares are covariances V (B, E, E), those of blocks for instance.

    Of correlations, scaled back: where one effect tells a billion times as much as another, in
    whatever unit, rounding would else give the other scores that it never has.
    """
    scale = np.sqrt(np.maximum(np.einsum("bii->bi", V), 0.0))
    unit = np.where(scale > 0.0, scale, 1.0)
    value, vector = np.linalg.eigh(V / (unit[:, :, None] * unit[:, None, :]))
    return scale[:, :, None] * vector * np.sqrt(np.maximum(value, 0.0))[:, None, :]


class _Form:
    """Parts of an effect's information by block that are needed.

    whiten: (B, k, q) rows whose squares sum to s_b' V_b^-1 s_b; of blocks that say nothing, zero.
    """

    def __init__(self, H: np.ndarray, follow: np.ndarray):
        """Args:
        H, follow: of the blocks, see `BlockInformation.of`.
        """
        _, k, q = follow.shape
        # an effect with an amplitude for each of many recordings: a block knows few of them
        root = roots(H).transpose(0, 2, 1) @ follow if k < q else None
        by_block = np.zeros((0, q, q)) if k < q else follow.transpose(0, 2, 1) @ H @ follow
        rows = None if root is None else root.reshape(-1, q)
        self.inverse = efficient_inverse(by_block.sum(axis=0) if rows is None else rows.T @ rows)
        if root is not None:
            trace = ((root @ self.inverse) * root).sum(axis=(1, 2))
        else:
            trace = np.einsum("ij,bji->b", self.inverse, by_block)
        self.telling = np.flatnonzero(trace > TELLING * max(trace.mean(), 1e-300))
        if root is not None:
            _, size, vector = np.linalg.svd(root[self.telling], full_matrices=False)
            value = size**2
            largest = value[:, :1]
        else:
            value, vector = np.linalg.eigh(by_block[self.telling])
            vector = vector.transpose(0, 2, 1)
            largest = value[:, -1:]
        live = value > 1e-6 * largest
        inverse_root = np.where(live, 1.0 / np.sqrt(np.where(live, value, 1.0)), 0.0)
        self.whiten = np.zeros((len(H), *vector.shape[1:]))
        self.whiten[self.telling] = inverse_root[:, :, None] * vector
        self.rank = int(np.linalg.matrix_rank(self.inverse, hermitian=True))
        self.count = int(live.sum())


class _Forms:
    """Forms of all variants; those with as many amplitudes are taken together.

    alike: by number of amplitudes, which variants (v,), their columns (v, q) and inverses
    (v, q, q), and what whitens their blocks (B, v, k, q); rank, count: (variants, 1).
    """

    def __init__(self, forms: Sequence[_Form], seen: Screen):
        columns = [np.arange(s.rows.start, s.rows.stop) for s in seen.scored]
        sizes = [f.whiten.shape[1:] for f in forms]
        self.alike = []
        for size in sorted(set(sizes)):
            which = np.array([i for i, s in enumerate(sizes) if s == size])
            mine = which.tolist()
            inverse = np.stack([forms[i].inverse for i in mine])
            whiten = np.stack([forms[i].whiten for i in mine], axis=1)
            self.alike.append((which, np.stack([columns[i] for i in mine]), inverse, whiten))
        self.rank = np.array([f.rank for f in forms])[:, None]
        self.count = np.array([f.count for f in forms])[:, None]


def dispersions(seen: Screen) -> np.ndarray:
    """phi of every scored variant (variants,): scatter of the blocks' scores over the noise's."""
    if not seen.scored:
        return np.ones(0)
    blocks, forms = _observed(seen)
    spread = np.zeros((len(forms.rank), 1))
    for which, columns, _, whiten in forms.alike:
        spread[which] = _spread(blocks[:, :, None], columns, whiten)
    return _phi(spread, forms.count)[:, 0]


def _observed(seen: Screen) -> tuple[np.ndarray, "_Forms"]:
    """Scores (B, E) by block, and what is needed of the information."""
    known = seen.by_block
    forms = _Forms([_Form(*known.of(s.rows)) for s in seen.scored], seen)
    blocks = np.zeros((len(known.H), known.effects))
    for s in seen.scored:
        blocks[: len(s.blocks), s.rows] = s.blocks
    return blocks, forms


def _spread(blocks: np.ndarray, columns: np.ndarray, whiten: np.ndarray) -> np.ndarray:
    """Sums of squares (v, draws) of the blocks' whitened scores, of variants alike in size."""
    spread = np.zeros((len(columns), blocks.shape[2]))
    for scores, rows in zip(blocks, whiten, strict=True):
        spread += ((rows @ scores[columns]) ** 2).sum(axis=1)
    return spread


def _phi(spread: np.ndarray, count: np.ndarray) -> np.ndarray:
    """The same by degree of freedom; few blocks are lent what is usual."""
    usual = np.median(spread / np.maximum(count, 1), axis=0)
    return (spread + LENT * usual) / (count + LENT)


def _statistics(blocks: np.ndarray, forms: _Forms, most: float) -> np.ndarray:
    """-log p of F of every variant (variants, draws), from scores (B, E, draws); phi at most so."""
    rank, count = forms.rank, forms.count
    explained = np.zeros((len(rank), blocks.shape[2]))
    spread = np.zeros_like(explained)
    totals = blocks.sum(axis=0)
    for which, columns, inverse, whiten in forms.alike:
        total = totals[columns]  # (v, q, draws)
        explained[which] = (inverse @ total * total).sum(axis=1)
        spread[which] = _spread(blocks, columns, whiten)
    phi = np.minimum(_phi(spread, count), most)
    F = explained / np.maximum(rank * phi, 1e-300)
    # one scale for effects of different numbers of amplitudes; exactness is not needed
    nobody = (rank == 0) | (count + LENT <= rank)
    p = tails.fisher(F, np.maximum(rank, 1), count + LENT)
    return np.where(nobody, 0.0, -np.log(np.maximum(p, LEAST)))
