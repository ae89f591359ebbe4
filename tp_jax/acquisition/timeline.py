"""Times of the samples on the rig's clock; which are missing, and which are believed.

A sample is believed at once where it follows from the last one: by its sequence number and its
time, or in a text stream, which has no numbers and no checksum, by its time alone. Any other is set
aside: a damaged digit, a repeated frame or a firmware's slip must not put a wrong time into a
recording, nor end it. Where the next ones follow from it, it was right: samples are missing, the
clock has jumped, or the rig has begun anew.

The counter behind the times of a text stream may wrap, which is told from a rig that has begun
anew by where it goes on, and may count milliseconds or microseconds, which is told by the host's
clock.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tp_jax.errors import InputError

WRAP = 1 << 32  # of numbers and times on the wire; the most samples that are counted as missing
LONGEST_STEP = 1000  # samples that may be missing at once before the next must be confirmed
TOLERANCE = 0.2  # by how much the time between two samples may differ from the period announced
BEHIND = 20  # samples behind the last up to which one is a repeated or a late one, no new begin
CONFIRMED = 3  # samples that must follow from each other to be right against all that was before
CONFIRMED_AHEAD = 2  # rows of text for the same after a gap

NEXT = 2.5  # periods within which the next row of text is expected
LEARNT_FROM, MOST_LOOKED_AT = 8, 2000  # rows of text from which the period is learnt
UNITS = {"seconds": 1.0, "milliseconds": 1e3, "microseconds": 1e6}
FAST = 2.0  # seconds that pass in one of the host's clock: then the unit is another
LISTENED, MOST_LISTENED = 0.5, 3.0  # seconds of the host's clock by which a unit is told
COUNTERS = 2.0**31, 2.0**32  # counts after which 32 bits wrap; a few drop the highest of them
WRAPPED_WITHIN = 10.0  # seconds after a wrap within which the next row is looked for


@dataclass(frozen=True)
class Gap:
    """Samples missing between two that are there, at the times after and before [s]."""

    after: float
    before: float
    samples: int


class Timeline:
    """Times of the samples of one run."""

    def __init__(self, period: float | None = None, begin: int = 0) -> None:
        """
        Args:
            period: between samples [s], as the rig announced it; None: a text stream.
            begin: time on the wire of sample 0 [µs].
        """
        self.period = period  # [s]; None in a text stream until it is known
        self.accepted = 0  # samples
        self.lost = 0  # between those, and, where they are numbered, before the first of them
        self.implausible = 0  # set aside and never confirmed
        self.repeated = 0  # those of them that have the time of the one before
        self.gaps: list[Gap] = []  # found since they were last taken away
        self.restarted = False  # the rig has begun anew; nothing more is accepted
        self.unit = "seconds"  # of the times of a text stream
        self.wraps: list[float] = []  # times [s] at which the counter behind them wrapped
        self._text = period is None
        # [µs] in whole numbers where the wire has them so, else [s], like all times in here
        self._scale = 1.0 if period is None else 1e6
        self._period = 0.0 if period is None else period * 1e6
        self._begin = begin
        self._number, self._time = -1, -round(self._period)  # as if sample -1 had been there
        self._at_once = 2 if self._text else LONGEST_STEP
        self._aside: list[tuple[int, Any, Any]] = []
        self._looked_at: list[np.ndarray] = []
        self._listened: list[tuple[float, int]] = []  # (host's clock, rows) first and last
        self._shift = 0.0  # [s] for the wraps so far

    @property
    def last(self) -> float | None:
        """Time of the last sample accepted [s]."""
        return None if self.period is None else self._time / self._scale

    def interrupted(self) -> None:
        """Says that the line was: any number of numbered samples may be missing before the next."""
        if not self._text:
            self._at_once = WRAP // 2

    def take_gaps(self) -> list[Gap]:
        """The gaps found since the last call."""
        gaps, self.gaps = self.gaps, []
        return gaps

    def feed(self, sequence: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places (n,) numbered samples in time, numbers and times [µs] as on the wire.

        Returns:
            (m,) indices of the samples that are believed, and their (m,) times since the begin of
            the run [s].
        """
        if self.restarted or not sequence.size:
            return np.empty(0, dtype=int), np.empty(0)
        number = sequence.astype(np.int64)
        since = (time.astype(np.int64) - self._begin) % WRAP
        steps = np.diff(number, prepend=self._number % WRAP) % WRAP
        elapsed = np.diff(since, prepend=self._time % WRAP) % WRAP
        follow = (steps >= 1) & (steps <= LONGEST_STEP) & self._agree(steps, elapsed)
        if follow.all() and not self._aside:
            times = self._time + np.cumsum(elapsed)
            for step, at in zip(steps.tolist(), times.tolist(), strict=True):
                self._accept(step, at)
            return np.arange(number.size), times / 1e6
        pairs = enumerate(zip(number.tolist(), since.tolist(), strict=True))
        found = [each for i, pair in pairs for each in self._one(*pair, i)]
        kept, placed = [i for i, _ in found], [t for _, t in found]
        return np.array(kept, dtype=int), np.array(placed, dtype=float) / 1e6

    # Text ---------------------------------------------------------------------------------------

    def feed_rows(self, rows: np.ndarray, host: float | None = None) -> np.ndarray:
        """Places (n, columns) rows of text in time, the time as it was printed first.

        Args:
            rows: as they came.
            host: the host's clock [s] at that; None: the times are seconds. InputError where it
                tells that they are in no unit.

        Returns:
            (m, columns) rows that are believed, earlier ones that were set aside among them, with
            the time [s] first.
        """
        if self.period is None and len(rows):
            self._looked_at += list(rows)
            self._listened[1:] = [] if host is None else [(host, len(self._looked_at))]
            rows = self._learn(last=len(self._looked_at) >= MOST_LOOKED_AT)
        kept: list[np.ndarray] = []
        for row in rows:
            time = self.seconds(float(row[0]))
            wrap = self._wrap(time)
            believed = self._one(0, round(time + wrap, 9) if wrap else time, row[1:])
            kept += [np.array([at, *readings]) for readings, at in believed]
            if believed and wrap:
                self._shift += wrap
                self.wraps.append(believed[0][1])
        return np.array(kept).reshape(len(kept), rows.shape[1])

    def rest(self) -> np.ndarray | None:
        """Rows held back while the period was not known, when the stream ends before it is."""
        return self.feed_rows(self._learn(last=True)) if self._looked_at else None

    def seconds(self, printed: float) -> float:
        """A printed time in seconds, carried on over the wraps so far."""
        t = printed / UNITS[self.unit]
        return round(t + self._shift, 9) if self._shift else t

    def _learn(self, last: bool) -> np.ndarray:
        """Finds period and unit if it can or has to; returns the rows looked at then, else none."""
        rows = np.array(self._looked_at)
        steps = np.diff(rows[:, 0])
        rising = steps[steps > 0.0]
        if not last and (len(rows) < LEARNT_FROM or rising.size < LEARNT_FROM // 2):
            return rows[:0]
        period = float(np.median(rising)) if rising.size else 1.0
        # Nobody samples a pendulum once a second or slower, but a counter of milliseconds looks so;
        # decimals of a millisecond at a high rate look like seconds that pass too fast.
        # The rows of the first bytes may have waited in a buffer, so they are not counted.
        begin, first = self._listened[0] if self._listened else (0.0, 1)
        end = self._listened[-1][0] if self._listened else begin
        span, counted = end - begin, period * int((steps[first - 1 :] > 0.0).sum())
        if self._listened and span == 0.0 and not last:
            return rows[:0]
        if self._listened and (period >= 1.0 or counted > FAST * span):
            unit = _unit(counted / span) if span > (0.0 if last else LISTENED) else None
            if unit is None and not last and span < MOST_LISTENED:
                return rows[:0]
            if unit is None and span > 0.0 and period >= 1.0:
                raise InputError(
                    f"The first number of each line rises by {counted / span:.3g} in a second, "
                    "which is no time in seconds, milliseconds or microseconds; print one of these."
                )
            self.unit = unit or self.unit
        self._looked_at = []
        self.period = self._period = period / UNITS[self.unit]
        # one period before the first row that the next one follows from
        ok = np.flatnonzero((steps > 0.0) & (steps <= NEXT * period))
        self._time = self.seconds(float(rows[ok[0] if ok.size else 0, 0])) - self.period
        return rows

    def _wrap(self, t: float) -> float:
        """Seconds by which a counter that has wrapped is behind; 0 where none has."""
        if t >= self._time - BEHIND * self._period:
            return 0.0
        for unit in UNITS.values() if self.unit == "seconds" else [UNITS[self.unit]]:
            for count in COUNTERS if unit > 1.0 else ():
                if 0.0 < t + count / unit - self._time <= WRAPPED_WITHIN:
                    return count / unit
        return 0.0

    # Both ---------------------------------------------------------------------------------------

    def _one(self, number: int, time: Any, payload: Any) -> list[tuple[Any, Any]]:
        """(payload, time) of the samples that are believed now that this one came."""
        if self.restarted:
            return []
        step, elapsed = self._between(self._number, self._time, number, time)
        if 1 <= step <= self._at_once and self._agree(step, elapsed):
            self._leave_aside()
            return [(payload, self._accept(step, time if self._text else self._time + elapsed))]
        if -BEHIND <= step <= 0:
            self.implausible += 1
            self.repeated += self._text and elapsed == 0.0
            return []
        if self._aside:
            further = self._between(*self._aside[-1][:2], number, time)
            limit = 2 if self._text else LONGEST_STEP
            if not (1 <= further[0] <= limit and self._agree(*further)):
                self._leave_aside()
        self._aside.append((number, time, payload))
        ahead = self._text and step > 0
        if len(self._aside) < (CONFIRMED_AHEAD if ahead else CONFIRMED):
            return []
        if ahead:  # of the rows after a gap none is left out
            aside, self._aside = self._aside, []
            return [
                (row, self._accept(self._between(0, self._time, 0, at)[0], at))
                for _, at, row in aside
            ]
        self._leave_aside()
        if not self._agree(step, elapsed):
            elapsed = (time - self._time) % WRAP  # the clock itself has jumped
        # beyond half its range the clock has gone on only where the sequence says so
        if self._text or step < 1 or not (self._agree(step, elapsed) or 0 < elapsed < WRAP // 2):
            self.restarted = True
            return []
        self.implausible -= 1  # the last of them is believed
        return [(payload, self._accept(step, self._time + elapsed))]

    def _between(self, number: int, time: Any, to_number: int, to_time: Any) -> tuple[int, Any]:
        """Samples and time from one sample to another; below zero: the other is behind."""
        if self._text:
            elapsed = to_time - time
            periods = min(abs(elapsed) / self._period, WRAP)
            return (max(round(periods), 1) if elapsed > 0.0 else -int(periods)), elapsed
        step = (to_number - number + WRAP // 2) % WRAP - WRAP // 2
        elapsed = (to_time - time) % WRAP
        # how often the clock has wrapped the sequence numbers tell
        return step, elapsed + WRAP * round((step * self._period - elapsed) / WRAP)

    def _agree(self, step: Any, elapsed: Any) -> Any:
        """True where so many steps took so long, numbers or (n,) arrays of them."""
        slack = TOLERANCE * step * self._period + 2.0 * self._period
        return (elapsed > 0) & (abs(elapsed - step * self._period) <= slack)

    def _accept(self, step: int, time: Any) -> Any:
        """Counts a sample that is believed, and the gap before it; returns its time."""
        # before the first of a text stream nothing is known to be missing
        if step > 1 and (self.accepted or not self._text):
            before = self._time if self._text else max(self._time, 0)
            self.lost += step - 1
            self.gaps.append(Gap(before / self._scale, time / self._scale, step - 1))
        self._number += step
        self._time = time
        self.accepted += 1
        if not self._text:
            self._at_once = LONGEST_STEP
        return time

    def _leave_aside(self) -> None:
        """Gives up the samples set aside."""
        self.implausible += len(self._aside)
        self._aside.clear()


def _unit(rate: float) -> str | None:
    """The unit of times that rise by so many a second; None where it is none of them."""
    return next((name for name, unit in UNITS.items() if 0.5 < rate / unit < 2.0), None)
