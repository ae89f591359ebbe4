"""Information of blocks of windows about effects, the fit's unknowns re-optimised.

A block says something of the numbers of its own recording alone, so it is held by slot: d columns,
however many recordings have a number of their own there. Those of effects are efficient: the
gradient by an effect less what the unknowns of the fit, which all blocks share, take of it. An
effect of another recording is seen by a block through these unknowns alone.
"""

import dataclasses
from collections.abc import Iterator

import numpy as np


@dataclasses.dataclass(frozen=True)
class BlockInformation:
    """Covariances of the blocks' scores where nothing but noise is in them.

    Attributes:
        H: (B, d, d) by a block's own columns: efficient scores, and gradients by the unknowns.
        to: (B, d) where a column stands among the E columns of effects and, after them, the u
            unknowns of the fit; -1 where it is neither.
        gain: (u, E) H_bb^-1 H_be: how far the unknowns go against the effects.
    """

    H: np.ndarray
    to: np.ndarray
    gain: np.ndarray

    @classmethod
    def of_gradients(cls, H: np.ndarray, to: np.ndarray, gain: np.ndarray) -> "BlockInformation":
        """Makes it from covariances (B, d, d) of the gradients by a block's own columns."""
        out = cls(H, to, gain)
        half = out.own_scores(H)
        return cls(out.own_scores(half.transpose(0, 2, 1)), to, gain)

    @property
    def effects(self) -> int:
        """Columns of effects, E."""
        return self.gain.shape[1]

    def _kinds(self) -> Iterator[tuple[np.ndarray, ...]]:
        """Blocks whose columns stand alike.

        Yields:
            which blocks; their columns of effects, and which effects these are; their columns of
            unknowns, and which unknowns.
        """
        rows, which = np.unique(self.to, axis=0, return_inverse=True)
        for i, row in enumerate(rows):
            effects = np.flatnonzero((row >= 0) & (row < self.effects))
            unknowns = np.flatnonzero(row >= self.effects)
            blocks = np.flatnonzero(which.ravel() == i)
            yield blocks, effects, row[effects], unknowns, row[unknowns] - self.effects

    def own_scores(self, gradients: np.ndarray) -> np.ndarray:
        """Scores (B, d, n) by the blocks' own columns, from gradients (B, d, n)."""
        out = gradients.copy()
        for blocks, effects, which, unknowns, those in self._kinds():
            taken = self.gain[np.ix_(those, which)].T @ gradients[np.ix_(blocks, unknowns)]
            out[np.ix_(blocks, effects)] -= taken
        return out

    def scores(self, own: np.ndarray) -> np.ndarray:
        """Efficient scores (B, E, n) of all effects, from those (B, d, n) by own columns."""
        out = np.zeros((len(self.H), self.effects, own.shape[2]))
        for blocks, effects, which, unknowns, those in self._kinds():
            others = np.setdiff1d(np.arange(self.effects), which)
            if others.size:
                taken = self.gain[np.ix_(those, others)].T @ own[np.ix_(blocks, unknowns)]
                out[np.ix_(blocks, others)] = -taken
            out[np.ix_(blocks, which)] = own[np.ix_(blocks, effects)]
        return out

    def after_the_fit(self, own: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        """Scores (B, d, n) by own columns once the unknowns have been fitted to all blocks.

        Args:
            own: (B, d, n) before. covariance: (u, u) of the unknowns.
        """
        total = np.zeros((len(self.gain), own.shape[2]))
        for blocks, _, _, unknowns, those in self._kinds():
            total[those] += own[np.ix_(blocks, unknowns)].sum(axis=0)
        step = covariance @ total
        out = np.empty_like(own)
        for blocks, _, _, unknowns, those in self._kinds():
            out[blocks] = own[blocks] - self.H[blocks][:, :, unknowns] @ step[those]
        return out

    def of(self, rows: slice) -> tuple[np.ndarray, np.ndarray]:
        """Some effects' columns (q,): H (B, k, k) of what they rest on, and how, follow (B, k, q).

        The blocks' information about them is follow' H follow.
        """
        mine = (self.to >= rows.start) & (self.to < rows.stop)
        q = rows.stop - rows.start
        elsewhere = mine.sum(axis=1) < q  # some of them are another recording's
        unknown = (self.to >= self.effects) & elsewhere[:, None]
        kept = np.flatnonzero((mine | unknown).any(axis=0))
        to, mine, unknown = self.to[:, kept], mine[:, kept], unknown[:, kept]
        follow = np.zeros((*to.shape, q))
        block, column = np.nonzero(unknown)
        follow[block, column] = -self.gain[to[block, column] - self.effects, rows]
        block, column = np.nonzero(mine)
        own = to[block, column] - rows.start
        follow[block, :, own] = 0.0  # what the unknowns take is in its score already
        follow[block, column, own] = 1.0
        return self.H[:, kept][:, :, kept], follow

    def dense(self) -> np.ndarray:
        """(B, E, E) information about all effects, by block."""
        H, follow = self.of(slice(0, self.effects))
        return follow.transpose(0, 2, 1) @ H @ follow
