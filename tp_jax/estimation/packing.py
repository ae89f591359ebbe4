"""Windows packed into the lanes of blocks, and what a block's program returns unpacked again."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tp_jax.estimation.placement import SHORTEST
from tp_jax.estimation.program import Block, Linearised
from tp_jax.estimation.windows import Prepared, Windows

LANES = 8  # lanes in a block; a lane holds several windows one after the other


class Packed(NamedTuple):
    """A block: its windows and their places (k, 4), see `place`; then its data."""

    which: np.ndarray
    places: np.ndarray
    block: Block


def packed(
    prepared: Sequence[Prepared],
    windows: Windows,
    which: np.ndarray,
    places: np.ndarray,
    capacity: int,
) -> Packed:
    """Some windows' data as a block has them.

    Args:
        prepared: the recordings.
        windows: all of them. which: those of this block. places: where they lie in it.
        capacity: samples of a lane.
    """
    n = capacity
    ts, data, weight = np.zeros((n, LANES)), np.zeros((n, 2, LANES)), np.zeros((n, 2, LANES))
    start = np.zeros((n, LANES), dtype=bool)
    begins = np.zeros((n // SHORTEST, LANES), dtype=int)
    prior = np.zeros((n // SHORTEST, 4, LANES))
    prior_weight = np.zeros((n // SHORTEST, 4, LANES))
    count = np.ones(LANES, dtype=int)
    for lane, mine, at in _lanes(which, places):
        p, first = prepared[int(windows.recording[mine[0]])], windows.first[mine]
        source = _samples(first, windows.count[mine])
        size = source.size
        ts[:size, lane], ts[size:, lane] = p.t[source], p.t[source[-1]]
        data[:size, :, lane] = p.y[source]
        weight[:size, :, lane] = np.where(p.channels, 1.0 / p.sigma, 0.0)
        start[at, lane], begins[: at.size, lane], count[lane] = True, at, size
        prior[: at.size, :, lane] = p.smooth[first]
        prior_weight[: at.size, :, lane] = 1.0 / p.smooth_sd[first]
    pieces = None
    if any(p.pieces is not None for p in prepared):
        pieces = packed_pieces([p.pieces for p in prepared], windows, which, places, n)
    block = Block(ts, count, start, data, weight, begins, prior, prior_weight, pieces)
    return Packed(which, places, block)


def packed_pieces(
    drives: Sequence[np.ndarray | None],
    windows: Windows,
    which: np.ndarray,
    places: np.ndarray,
    capacity: int,
) -> np.ndarray:
    """Pieces (n - 1, 4, L) of the recordings' measured drives as a block has them."""
    pieces = np.zeros((capacity - 1, 4, LANES))
    for i, (_, lane, at, _) in zip(which, places, strict=True):
        read, f, c = drives[int(windows.recording[i])], windows.first[i], windows.count[i]
        if read is not None:
            pieces[at : at + c - 1, :, lane] = read[f : f + c - 1]
    return pieces


def _lanes(which: np.ndarray, places: np.ndarray):
    """Every lane, its windows in their order and where they begin."""
    order = np.lexsort((places[:, 3], places[:, 1]))
    edges = np.flatnonzero(np.diff(places[order, 1])) + 1
    for part in np.split(order, edges) if order.size else ():
        yield places[part[0], 1], which[part], places[part, 2]


def _samples(first: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Samples of windows, one after the other."""
    at = np.cumsum(count) - count
    return np.repeat(first - at, count) + np.arange(count.sum())


class Rows(NamedTuple):
    """Places of windows' samples in a block (L n,), and among rows of all windows' (w, n)."""

    block: np.ndarray
    window: np.ndarray
    row: np.ndarray


def rows(windows: Windows, packed: Packed) -> Rows:
    """Returns the rows of one block."""
    which, places, block = packed
    count = windows.count[which]
    row = _samples(np.zeros_like(count), count)
    first = places[:, 1] * len(block.ts) + places[:, 2]
    return Rows(np.repeat(first, count) + row, np.repeat(which, count), row)


def steps_of(out: Linearised, windows: Windows, which: np.ndarray, places: np.ndarray):
    """Steps (k,) that a block's windows took."""
    taken = np.asarray(out.taken)
    _, lane, at, _ = places.T
    return taken[lane, at + windows.count[which] - 1] - taken[lane, at] + 1.0
