"""Times that were rounded: rows that came evenly are put where they were.

Readings 4 ms apart whose times have two decimals come in twos and threes of the same time. Times
that are even and then rounded to whole quanta lie in a band of one quantum about a straight line
over the number of the row: where they do, the line is known far better than the quantum.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tp_jax.recordings.gaps import LONGEST_STEP
from tp_jax.recordings.short import short_fields


@dataclass(frozen=True)
class RoundingPolicy:
    """Conditions under which times are taken for rounded ones of rows that came evenly.

    Attributes:
        coarse: quantum over step from which it matters; less displaces a reading by a twentieth
            of a step at most.
        exact: quanta by which times may lie beside the band of one for want of a better line; where
            no line does, rows may be missing.
        slack: quanta by which times may lie beside the band of one, as a clock that trembles
            makes them.
        odd: steps unlike the usual one that there must be; fewer are rows that went wrong.
        beats: as `odd`, where the usual step is one quantum, as it is where rows are missing.
        expected: part of the odd steps that rounding makes, by which they may be fewer, and
            inverse by which more.
        rows: in a piece between two places where rows are missing, on average, at least.
        same: share of rows with a repeated time that repeat the readings too, above which rows
            were written twice.
        repeated: share of repeated times above which they are rounded for certain.
    """

    coarse: float = 0.1
    exact: float = 0.02
    slack: float = 0.25
    odd: int = 3
    beats: int = 8
    expected: float = 0.5
    rows: int = 20
    same: float = 0.99
    repeated: float = 0.05


POLICY = RoundingPolicy()

_LAG = 50
"""Quanta or rows over which the spacing is first estimated, where rows may be missing."""

_BLOCK = 64
"""Rows that are looked over first for the next cut."""


@dataclass(frozen=True)
class Even:
    """Times put where their rows came.

    Attributes:
        t: (n,) times.
        quantum: to which they were rounded.
        step: between rows.
    """

    __repr__ = short_fields

    t: np.ndarray
    quantum: float
    step: float


def quantum_of(t: np.ndarray) -> float | None:
    """The quantum that all steps of rising times are whole multiples of; None: there is none."""
    steps = np.diff(t)
    fine = max(4.0 * np.finfo(float).eps * float(np.abs(t).max()), 1e-9 * float(np.ptp(t)))
    sizes = np.unique(steps[steps > fine])
    if not sizes.size or sizes.size > 1000:
        return None
    apart = np.diff(sizes)
    step = float(min(sizes[0], apart[apart > fine].min(initial=np.inf)))
    whole = sizes / step
    return step if np.all(np.abs(whole - np.rint(whole)) < 1e-3 + fine / step) else None


def rounded(t: np.ndarray, same: np.ndarray, policy: RoundingPolicy = POLICY) -> float | None:
    """The quantum of times that repeat because they are rounded; None where they do not.

    Args:
        t: (n,) times that do not fall.
        same: (n - 1,) whether a row repeats the readings of the one before.
        policy: what decides.
    """
    still = np.diff(t) == 0.0
    if np.mean(still) < policy.repeated or np.mean(same[still]) > policy.same:
        return None
    return quantum_of(t)


def made_even(t: np.ndarray, same: np.ndarray, policy: RoundingPolicy = POLICY) -> Even | None:
    """Rounded times of rows that came evenly, put where they were; None where they are not such.

    Args:
        t: (n,) times that do not fall.
        same: (n - 1,) whether a row repeats the readings of the one before.
        policy: what decides.
    """
    if t.size < 2 * policy.rows or np.any(t[1:] < t[:-1]):
        return None
    steps = np.diff(t)
    still = steps == 0.0
    if still.any() and np.mean(same[still]) > policy.same:
        return None
    quantum = quantum_of(t)
    if quantum is None or quantum < policy.coarse * float(np.mean(steps)):
        return None
    v = np.rint((t - t[0]) / quantum)
    cuts = np.flatnonzero(np.diff(v) > LONGEST_STEP * max(1.0, float(np.median(np.diff(v))))) + 1
    if not still.any() and np.median(np.diff(v)) == 1.0:
        # even rows of which some are missing have steps of whole ones, too, but not evenly
        odd = np.sum(np.diff(v) != 1.0)
        one = _fitted(v, cuts[:0], policy.exact, policy, pieces=1) if odd >= policy.beats else None
        return one and Even(t[0] + quantum * one[0], quantum, quantum * one[1])
    for slack in (policy.exact, policy.slack):
        found = _fitted(v, cuts, slack, policy)
        if found is not None:
            even, spacing = found
            return Even(t[0] + quantum * even, quantum, quantum * spacing)
    return None


def _fitted(
    v: np.ndarray, cuts: np.ndarray, slack: float, policy: RoundingPolicy, pieces: float = np.inf
) -> tuple[np.ndarray, float] | None:
    """Rows in quanta, even between the cuts and where rows are missing, and the spacing."""
    for _ in range(4):
        edges = [0, *cuts.tolist(), v.size]
        parts = [v[a:b] for a, b in pairwise(edges)]
        most = min(pieces, v.size / policy.rows)
        if len(parts) > most:
            return None
        spacing = _spacing(parts)
        if spacing is None or not _as_rounded(parts, spacing, policy):
            return None
        offsets = [_offset(part, spacing) for part in parts]
        off = [p - a - spacing * np.arange(p.size) for p, a in zip(parts, offsets, strict=True)]
        if max(float(np.ptp(each)) for each in off) <= 1.0 + 2.0 * slack:
            return _joined(parts, offsets, spacing), spacing
        found = _where_rows_miss(parts, edges, _robust_spacing(v) or spacing, slack, most)
        if found is None:
            return None
        cuts = found
    return None


def _changes(part: np.ndarray) -> np.ndarray:
    return np.flatnonzero(np.diff(part) > 0.0) + 1


def _spacing(parts: list[np.ndarray]) -> float | None:
    """Quanta from row to row, one for all parts, each of which begins where it likes."""
    few = sum(p[-1] - p[0] for p in parts) < sum(p.size - 1 for p in parts)
    above, below = 0.0, 0.0
    for part in parts:
        rows = np.arange(part.size)
        if few:  # several rows to a quantum: the rows at which it changes tell more
            rows = _changes(part)
        if rows.size < 2:
            continue
        x, y = rows - rows.mean(), part[rows] - part[rows].mean()
        above += float(np.sum(y * y) if few else np.sum(x * y))
        below += float(np.sum(x * y) if few else np.sum(x * x))
    return above / below if below > 0.0 and above > 0.0 else None


def _robust_spacing(v: np.ndarray) -> float | None:
    """Estimates what `_spacing` does, but a few missing rows do not move it."""
    few = v[-1] - v[0] < v.size - 1
    rows = _changes(v) if few else np.arange(v.size)
    lag = min(_LAG, rows.size // 4)
    if lag < 1:
        return None
    ways = (v[rows[lag:]] - v[rows[:-lag]]) / (rows[lag:] - rows[:-lag])
    return float(np.median(ways))


def _offset(part: np.ndarray, spacing: float) -> float:
    """Finds where the first row of a part was, in quanta."""
    rows = _changes(part)
    if spacing >= 1.0 or not rows.size:
        return float(np.mean(part - spacing * np.arange(part.size)))
    # half a quantum below the new one was passed half a row before it, on average
    return float(np.mean(part[rows] - 0.5 - spacing * (rows - 0.5)))


def _as_rounded(parts: list[np.ndarray], spacing: float, policy: RoundingPolicy) -> bool:
    """True if there are as many odd steps as rounding makes."""
    steps = np.concatenate([np.diff(part) for part in parts])
    odd = int(np.sum(steps != np.rint(spacing)))
    expected = abs(spacing - np.rint(spacing)) * steps.size
    return bool(
        odd >= policy.odd and policy.expected * expected <= odd <= expected / policy.expected
    )


def _where_rows_miss(
    parts: list[np.ndarray], edges: list[int], spacing: float, slack: float, most: float = np.inf
) -> np.ndarray | None:
    """Rows from which on no line of this spacing goes through the bands of those before.

    None: they are so many that more than `most` pieces would be left.
    """
    cuts = edges[1:-1]
    for part, begin in zip(parts, edges, strict=False):
        rest = part - spacing * np.arange(part.size)
        at = _first_beyond(rest, 0, 1.0 + slack)
        while at is not None:
            cuts.append(begin + at)
            if len(cuts) + 1 > most:
                return None
            at = _first_beyond(rest, at, 1.0 + slack)
    return np.array(sorted({*cuts}), dtype=int)


def _first_beyond(rest: np.ndarray, begin: int, wide: float) -> int | None:
    """Index from which on the values since `begin` span more than `wide`; None: they never do."""
    # Where times tremble a cut comes every few rows: to look over all the rest for each of them
    # takes the square of the rows, blocks that double no more than twice the way to the next.
    low, high, size = -np.inf, np.inf, _BLOCK
    while begin < rest.size:
        block = rest[begin : begin + size]
        lows = np.maximum(np.maximum.accumulate(block), low)
        highs = np.minimum(np.minimum.accumulate(block), high)
        beyond = np.flatnonzero(lows - highs > wide)
        if beyond.size:
            return begin + int(beyond[0])
        low, high = lows[-1], highs[-1]
        begin += block.size
        size *= 2
    return None


def _joined(parts: list[np.ndarray], offsets: list[float], spacing: float) -> np.ndarray:
    """All rows in quanta; a part goes on in whole steps from the one before where it can."""
    placed = []
    for part, offset in zip(parts, offsets, strict=True):
        begin = offset
        if placed:
            last = float(placed[-1][-1])
            whole = last + spacing * max(1.0, np.rint((offset - last) / spacing))
            near = abs(whole - offset) <= 0.5
            begin = whole if near else max(offset, last + 0.5 * spacing)
        placed.append(begin + spacing * np.arange(part.size))
    return np.concatenate(placed)
