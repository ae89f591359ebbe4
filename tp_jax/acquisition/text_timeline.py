"""Which rows of a text stream are believed, by their times alone.

A row that follows the last one within `NEXT` periods is believed at once. One that jumps ahead is
set aside until the next row follows from it: then there is a gap; otherwise a digit was damaged.
Rows a little behind are such as well; rows far behind, confirmed, are a rig that has begun anew.
"""

import numpy as np

from tp_jax.acquisition.timeline import Gap

NEXT = 2.5
"""Periods within which the next row is expected."""

BEHIND = 20.0
"""Periods behind the last row from which on the rig may have begun anew."""

CONFIRMED = 3
"""Rows that must follow from each other before a rig is said to have begun anew."""

LEARNT_FROM = 8
"""Rows that are looked at together for the period before the first is believed."""

MOST_MISSING = 2**32
"""Samples missing at once that are counted: a damaged period would have made them any number."""


class TextTimeline:
    """Filters rows; attributes as in `timeline.Timeline`, period in seconds, None until known.

    `lost` is counted by the times that are missing: a text stream has no sequence numbers.
    """

    def __init__(self) -> None:
        self.period: float | None = None
        self.accepted = 0
        self.lost = 0
        self.implausible = 0
        self.gaps: list[Gap] = []
        self.restarted = False
        self.last: float | None = None
        self._aside: list[np.ndarray] = []

    def feed(self, rows: np.ndarray) -> np.ndarray:
        """(m, columns) rows that are believed, of (n, columns) rows with the time [s] first."""
        if self.restarted or not len(rows):
            return rows[:0]
        if self.period is None:
            self._aside += list(rows)
            if len(self._aside) < LEARNT_FROM:
                return rows[:0]
            rows, self._aside = np.array(self._aside), []
            self._learn(rows[:, 0])
            if self.period is None:
                return rows[:0]
        if not self._aside and self.last is not None:
            steps = np.diff(rows[:, 0], prepend=self.last)
            if steps.min() > 0.0 and steps.max() <= NEXT * self.period:
                self._note(rows)
                return rows
        kept: list[np.ndarray] = []
        for row in rows:
            believed = self._one(row)
            if believed:
                self._note(np.array(believed))
                kept += believed
            if self.restarted:
                break
        return np.array(kept).reshape(len(kept), rows.shape[1])

    def rest(self) -> np.ndarray | None:
        """Rows held back while the period was not known, when the stream ends before it is."""
        if self.period is not None or not self._aside:
            return None
        rows, self._aside = np.array(self._aside), []
        rising = np.concatenate([[True], np.diff(np.maximum.accumulate(rows[:, 0])) > 0.0])
        self.accepted += int(rising.sum())
        return rows[rising]

    def take_gaps(self) -> list[Gap]:
        """The gaps found since the last call."""
        gaps, self.gaps = self.gaps, []
        return gaps

    def interrupted(self) -> None:
        """The line was; nothing to do, since a jump is confirmed by the row after it."""

    def _learn(self, t: np.ndarray) -> None:
        steps = np.diff(t)
        rising = steps[steps > 0.0]
        if rising.size < LEARNT_FROM // 2:
            self.implausible += t.size
            return
        self.period = float(np.median(rising))
        # one period before the first row that the next one follows from
        ok = np.flatnonzero((steps > 0.0) & (steps <= NEXT * self.period))
        first = int(ok[0]) if ok.size else 0
        self.last = float(t[first]) - self.period

    def _one(self, row: np.ndarray) -> list[np.ndarray]:
        assert self.period is not None
        assert self.last is not None
        ahead = (row[0] - self.last) / self.period
        if 0.0 < ahead <= NEXT:
            self._drop_aside()
            return [row]
        if -BEHIND <= ahead <= 0.0:
            self.implausible += 1
            return []
        if self._aside and not 0.0 < row[0] - self._aside[-1][0] <= NEXT * self.period:
            self._drop_aside()
        self._aside.append(row)
        if ahead > 0.0 and len(self._aside) > 1:
            believed, self._aside = self._aside, []
            return believed
        if len(self._aside) >= CONFIRMED:
            self._drop_aside()
            self.restarted = True
        return []

    def _note(self, rows: np.ndarray) -> None:
        """Counts believed rows and the gaps between them."""
        assert self.period is not None
        assert self.last is not None
        t = np.concatenate([[self.last], rows[:, 0]])
        missing = np.rint(np.diff(t) / self.period) - 1.0
        missing = np.clip(missing, 0.0, MOST_MISSING).astype(int)
        if self.accepted == 0:
            missing[0] = 0
        for i in np.flatnonzero(missing):
            self.gaps.append(Gap(float(t[i]), float(t[i + 1]), int(missing[i])))
        self.lost += int(missing.sum())
        self.accepted += len(rows)
        self.last = float(t[-1])

    def _drop_aside(self) -> None:
        self.implausible += len(self._aside)
        self._aside.clear()
