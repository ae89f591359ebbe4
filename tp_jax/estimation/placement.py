"""Windows that share a lane, chosen so that all lanes of a block end at about the same time.

A block is done when its slowest lane is, and what a window costs differs by a factor of four: a
reversal of either velocity takes as many steps as some eighty samples between reversals. Windows
are given to lanes by what they are expected to cost, the costly ones first, each to the lane that
has least (Graham, 1969, SIAM J. Appl. Math. 17, 416-429).
"""

import heapq
from collections.abc import Iterable, Sequence

import numpy as np

from tp_jax.estimation.windows import Prepared, Windows

PER_SAMPLE, PER_REVERSAL = 0.56, 43.0  # steps of the engine
SHORTEST = 8  # samples: a window takes as much room at least, so that a lane holds not too many
MORE = 2  # blocks that there may be beyond those that the samples need
PER_BLOCK = 60.0  # steps that the readings of a block and its way there and back take as long as
OF_BOTH = 0.2  # weight of what both threads take in addition to what the longer one takes
AT_REST = 3.0  # standard errors below which a velocity has no sign


def expected_steps(windows: Windows, prepared: Sequence[Prepared]) -> np.ndarray:
    """Steps (w,) that windows will take, from the readings alone."""
    passed = []  # reversals until each sample
    for p in prepared:
        total = np.zeros(p.t.size)
        for c in np.flatnonzero(p.channels):
            v = p.smooth[:, 2 + c]
            moving = np.flatnonzero(np.abs(v) > AT_REST * p.smooth_sd[:, 2 + c])
            turned = np.flatnonzero(np.diff(np.sign(v[moving])) != 0.0)
            total[moving[turned + 1]] += 1.0
        passed.append(np.cumsum(total))
    last = windows.first + windows.count - 1
    reversals = np.array(
        [
            passed[r][b] - passed[r][a]
            for r, a, b in zip(windows.recording, windows.first, last, strict=True)
        ]
    )
    return PER_SAMPLE * windows.count + PER_REVERSAL * reversals


class Experience:
    """Steps that windows were seen to take, of all problems of a campaign."""

    def __init__(self) -> None:
        self._steps: dict[tuple[int, int, int], float] = {}

    def expected(self, windows: Windows, prepared: Sequence[Prepared]) -> np.ndarray:
        """Steps (w,) that windows will take: what they took, or else from the readings alone."""
        seen = np.array([self._steps.get(key, np.nan) for key in _keys(windows)])
        known = np.isfinite(seen)
        if known.all():
            return seen
        guess = expected_steps(windows, prepared)
        scale = seen[known].sum() / guess[known].sum() if known.any() else 1.0
        return np.where(known, seen, scale * guess)

    def learn(self, windows: Windows, steps: np.ndarray) -> None:
        """Takes note of the steps (w,) that windows took."""
        self._steps.update(zip(_keys(windows), steps.tolist(), strict=True))


def _keys(windows: Windows) -> Iterable[tuple[int, int, int]]:
    w = windows
    return zip(w.recording.tolist(), w.first.tolist(), w.count.tolist(), strict=True)


def longest(places: np.ndarray, cost: np.ndarray) -> float:
    """Computes what the slowest lanes of all blocks take together."""
    lanes = np.zeros((int(places[:, 0].max()) + 1, int(places[:, 1].max()) + 1))
    np.add.at(lanes, (places[:, 0], places[:, 1]), cost)
    return float(lanes.max(axis=1).sum())


def place(windows: Windows, cost: np.ndarray, capacity: int, width: int) -> np.ndarray:
    """Block, lane within it, first sample within the lane, and rank there of every window (w, 4).

    A lane has one set of numbers, so it holds windows of one recording only. There are as many
    blocks as the samples need, or a few more where two threads are then done sooner: with as few
    lanes as can hold it, a recording of many reversals may take as long as all others together.

    Args:
        windows: what is to be placed. cost: (w,) of each.
        capacity: samples of a lane. width: lanes of a block.
    """
    if windows.n <= width and windows.count.max(initial=0) <= capacity:  # a lane for each
        order = np.argsort(-cost, kind="stable")
        places = np.zeros((windows.n, 4), dtype=int)
        places[order, 1] = np.arange(windows.n)
        return places
    found = [_place(windows, cost, capacity, width, more) for more in range(MORE + 1)]
    return min(found, key=lambda places: _time(places, cost))


def _time(places: np.ndarray, cost: np.ndarray) -> float:
    """Computes the time of two threads for blocks, each as long as its slowest lane."""
    lanes = np.zeros((int(places[:, 0].max()) + 1, int(places[:, 1].max()) + 1))
    np.add.at(lanes, (places[:, 0], places[:, 1]), cost)
    threads = [0.0, 0.0]
    for block in map(float, lanes.max(axis=1)):  # slow ones first
        threads[threads.index(min(threads))] += block + PER_BLOCK
    return max(threads) + OF_BOTH * sum(threads)


def _place(windows: Windows, cost: np.ndarray, capacity: int, width: int, more: int) -> np.ndarray:
    """Places windows with so many blocks more than the samples need."""
    groups = [np.flatnonzero(windows.recording == r) for r in np.unique(windows.recording)]
    room_for = np.maximum(windows.count, SHORTEST)
    lanes = [_least(room_for[g], cost[g], capacity) for g in groups]
    room = (-(-sum(map(len, lanes)) // width) + more) * width - sum(map(len, lanes))
    worst = [_slowest(cost[g], at) for g, at in zip(groups, lanes, strict=True)]
    for _ in range(room):  # one more for the recording whose slowest lane is the slowest of all
        i = int(np.argmax(worst))
        if worst[i] < 0.0:
            break
        g = groups[i]
        split = _shared(room_for[g], cost[g], capacity, len(lanes[i]) + 1)
        if split is None:
            break
        lanes[i], worst[i] = split, _slowest(cost[g], split)
    every = [np.sort(g[lane]) for g, at in zip(groups, lanes, strict=True) for lane in at]
    every.sort(key=lambda lane: -cost[lane].sum())  # slow ones together
    places = np.zeros((windows.n, 4), dtype=int)
    for i, lane in enumerate(every):
        places[lane, 0], places[lane, 1] = divmod(i, width)
        places[lane, 2] = np.cumsum(windows.count[lane]) - windows.count[lane]
        places[lane, 3] = np.arange(lane.size)
    return places


def _slowest(cost: np.ndarray, lanes: list[np.ndarray]) -> float:
    """Computes the cost of a recording's slowest lane; -1 where every window has its own lane."""
    return max(cost[lane].sum() for lane in lanes) if len(lanes) < cost.size else -1.0


def _least(count: np.ndarray, cost: np.ndarray, capacity: int) -> list[np.ndarray]:
    """Windows of one recording in as few lanes as hold them."""
    if count.max(initial=0) > capacity:
        raise ValueError(f"A window of {count.max()} samples is in no lane of {capacity}.")
    n = -(-int(count.sum()) // capacity)
    while True:
        found = _shared(count, cost, capacity, n)
        if found is not None:
            return found
        n += 1


def _shared(count: np.ndarray, cost: np.ndarray, capacity: int, n: int) -> list[np.ndarray] | None:
    """Windows in n lanes of about the same cost; None where they do not fit."""
    used = [0] * n
    members: list[list[int]] = [[] for _ in range(n)]
    lanes = [(0.0, lane) for lane in range(n)]  # a heap: the lane that has least is first
    samples, costs = count.tolist(), cost.tolist()
    for i in np.argsort(-cost, kind="stable").tolist():
        full = []
        while lanes and used[lanes[0][1]] + samples[i] > capacity:
            full.append(heapq.heappop(lanes))
        if not lanes:
            return None
        load, lane = lanes[0]
        heapq.heapreplace(lanes, (load + costs[i], lane))
        members[lane].append(i)
        used[lane] += samples[i]
        for one in full:
            heapq.heappush(lanes, one)
    return [np.array(m, dtype=int) for m in members if m]
