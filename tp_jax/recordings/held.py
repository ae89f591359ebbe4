"""Readings that are held: those of a sensor slower than the file, each written several times.

New readings then come in rows that are evenly apart, not necessarily by a whole number. A coarse
sensor repeats its readings too, but in rows that depend on how fast it turns.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tp_jax.recordings.short import short_fields


@dataclass(frozen=True)
class HeldPolicy:
    """Conditions under which repeated readings are taken for held ones.

    Attributes:
        repeated: share of the rows that repeat a reading, at least; 245 readings a second written
            at 250 have as many.
        least: new readings, and repeated ones, that there must be.
        band: rows within which new readings lie about even ones; 1 is what a clock that runs evenly
            makes, the rest is what its rate is not known to.
        strays: share of new readings that may lie beside it.
        wide: rows to a reading from which a sensor's clock may drift, as long as each reading
            lasts as long as the others but for a row.
        chance: share of repeated readings in addition to those that are held, at most, where a
            coarse sensor repeats some by chance; where it turns round, neighbours are repeated
            alike.
        speed: of the motion about repeated rows, over that elsewhere, at least; about its turning
            points a coarse sensor repeats its readings, and evenly where the motion is.
        quanta: steps of a coarse sensor that turns slowly are of one quantum; held ones are larger
            than one and a half in this share of the rows at least.
    """

    repeated: float = 0.015
    least: int = 20
    band: float = 1.1
    strays: float = 0.01
    wide: float = 3.0
    chance: float = 0.7
    speed: float = 0.5
    quanta: float = 0.2


POLICY = HeldPolicy()

_NEAR = 5e-3
"""Rows by which a new reading may seem to come after the row that has it."""

_TOGETHER = 0.5
"""Rows apart up to which two channels were read at once: neither is known better."""

_LONG = 100_000
"""Rows whose spectrum is fine enough with less padding."""

_TRIED = 12
"""Peaks of a spectrum that are looked at."""


@dataclass(frozen=True)
class Held:
    """Readings that were held.

    Attributes:
        rows: to a reading, on average.
        first: (k,) indices of the rows in which a new reading stands first.
        at: (k,) when it was new, in rows; at or less than one row before `first`.
    """

    __repr__ = short_fields

    rows: float
    first: np.ndarray
    at: np.ndarray


def held(x: np.ndarray, policy: HeldPolicy = POLICY) -> Held | None:
    """Finds how the readings of a channel were held; None where they were not.

    Args:
        x: (n,) readings.
        policy: what decides.
    """
    steps = np.abs(np.diff(x))
    first = np.flatnonzero(steps) + 1
    repeated = steps.size - first.size
    if first.size < policy.least or repeated < max(policy.least, policy.repeated * x.size):
        return None
    sizes = steps[first - 1]
    if np.mean(sizes > 1.5 * sizes.min()) < policy.quanta:
        return None
    lasts = np.diff(first)
    rows = _usual(lasts)
    # what is equal by chance hides a new reading; of two rows to a reading one cannot tell
    which = np.concatenate([[0], np.cumsum(np.rint(lasts / rows) if rows >= 2.0 else lasts > 0)])
    rows, early, late = _line(which, first, policy)
    if rows < 2.0 and not _as_fast(x, steps == 0.0, policy):
        return None
    if late - early <= policy.band:
        return _even(rows, early, x)
    found = _few_repeated(x, policy)
    if found is not None:
        return found
    usual = float(np.median(lasts))
    if usual >= policy.wide and np.mean(np.abs(lasts - usual) <= 1) >= 1.0 - 2.0 * policy.strays:
        rows = float(np.mean(lasts))
        return Held(rows, first, first.astype(float))
    return None


def _as_fast(x: np.ndarray, same: np.ndarray, policy: HeldPolicy) -> bool:
    """True if the readings move on about the rows that repeat as they do about others."""
    way = np.abs(x[3:] - x[:-3])
    return float(np.median(way[same[1:-1]])) >= policy.speed * float(np.median(way))


def _even(rows: float, early: float, x: np.ndarray) -> Held:
    """Readings every so many rows, of which one was new in row `early`."""
    n = x.size
    at = early + rows * np.arange(-np.floor((early + 0.01) / rows), (n - 1 - early) / rows + 0.01)
    at = np.clip(at, 0.0, n - 1.0)
    first = np.ceil(at - _NEAR).astype(int)
    # where the line is not known well enough the change of the reading tells the row
    new = np.concatenate([[True], x[1:] != x[:-1], [False]])
    later = (first - at < _NEAR) & ~new[first] & new[first + 1]
    return Held(rows, first + later, at)


def _few_repeated(x: np.ndarray, policy: HeldPolicy) -> Held | None:
    """Does what `held` does, for a coarse sensor with fewer than two rows to a reading.

    Not the new readings but the repeated rows are far and evenly apart then; others, that are
    equal by chance, lie in between.
    """
    same = np.diff(x) == 0.0
    n = same.size
    finer = 8 if n < _LONG else 2
    power = np.abs(np.fft.rfft(same - same.mean(), finer * n)) ** 2
    power[: int(np.ceil(0.5 * finer * n * policy.repeated))] = 0.0
    top = np.flatnonzero((power > np.roll(power, 1)) & (power >= np.roll(power, -1)))
    # a comb has all its overtones: the lowest that fits is it
    strong = top[power[top] > 0.3 * power.max()][:_TRIED]
    for apart in float(finer * n) / strong:
        comb = _comb(same, float(apart), policy)
        if comb is None:
            continue
        apart, at = comb
        rows = apart / (apart - 1.0)
        # row i repeats where (i - early) / rows is beyond a whole number by 1 / rows and more
        early = -(rows - 1.0) * (at + 1.0) - 0.5 * (rows + 1.0)
        return _even(rows, early % rows, x)
    return None


def _comb(same: np.ndarray, apart: float, policy: HeldPolicy) -> tuple[float, float] | None:
    """Rows between the teeth of the comb of repeated rows, and the first; None: it is none."""
    repeats = np.flatnonzero(same)
    phase = 0.0
    for _ in range(3):
        phase = float(np.angle(np.mean(np.exp(2j * np.pi * repeats / apart)))) / (2.0 * np.pi)
        which = np.rint(repeats / apart - phase)
        near = np.abs(repeats - apart * (which + phase)) <= 0.5 * policy.band
        if near.sum() < policy.least:
            return None
        x = which[near] - which[near].mean()
        apart = float(np.sum(x * repeats[near]) / np.sum(x * x))
        phase = float(np.mean(repeats[near] - apart * which[near])) / apart
    teeth = np.rint(apart * (np.arange(same.size / apart) + phase % 1.0)).astype(int)
    teeth = teeth[(teeth > 0) & (teeth < same.size - 1)]
    before, there, behind = (np.mean(same[teeth + way]) for way in (-1, 0, 1))
    if apart < 2.0 or there < 1.0 - 2.0 * policy.strays or max(before, behind) > policy.chance:
        return None
    return apart, apart * (phase % 1.0)


def _usual(lasts: np.ndarray) -> float:
    """Rows to a reading, from the two neighbouring lengths that most of them have."""
    counts = np.bincount(lasts)
    pairs = counts[:-1] + counts[1:]
    m = int(np.argmax(pairs))
    return float((m * counts[m] + (m + 1) * counts[m + 1]) / pairs[m])


def _line(which: np.ndarray, first: np.ndarray, policy: HeldPolicy) -> tuple[float, float, float]:
    """Rows to a reading, and the least and greatest row of reading 0 by the others, but strays."""
    x = which - which.mean()
    rows = float(np.sum(x * first) / np.sum(x * x))
    rest = first - rows * which
    early, late = np.quantile(rest, [0.5 * policy.strays, 1.0 - 0.5 * policy.strays])
    exact = float(rest.min()) if rest.min() > early - 0.05 else float(early)
    return rows, exact, float(late)


def new_only(
    t: np.ndarray, columns: Mapping[str, np.ndarray], policy: HeldPolicy = POLICY
) -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray, dict[str, Held]] | None:
    """Each reading once: of the slowest channel as it came, of others at the same times.

    Args:
        t: (n,) rising times of the rows.
        columns: name -> (n,) readings.
        policy: what decides.

    Returns:
        Times (k,), columns of as many readings, the rows that they came from, and how which
        columns were held; None where none was.
    """
    found = {name: each for name, x in columns.items() if (each := held(x, policy)) is not None}
    if not found:
        return None
    slowest = max(found.values(), key=lambda each: each.rows)
    rows = np.arange(t.size)
    out = {}
    for name, x in columns.items():
        mine = found.get(name)
        if mine is None:
            out[name] = np.interp(slowest.at, rows, x)
            continue
        nearest = np.rint(np.interp(slowest.at, mine.at, np.arange(mine.at.size))).astype(int)
        if np.abs(mine.at[nearest] - slowest.at).max() <= _TOGETHER:  # read at the same time
            out[name] = x[mine.first[nearest]]
        else:
            out[name] = np.interp(slowest.at, mine.at, x[mine.first])
    return np.interp(slowest.at, rows, t), out, slowest.first, found
