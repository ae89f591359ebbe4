"""When the samples were taken, on the rig's clock, and which are missing.

A frame whose checksum passes is believed only where its time and its sequence number agree with
what came before: a clock that wraps, a repeated frame, a firmware's slip or the one damaged frame
in 2^32 that the checksum lets through must not put a wrong time into a recording, nor end it.
What does not agree is set aside; where `CONFIRMED` of them in a row agree with each other, they
are right and the time did jump.
"""

from dataclasses import dataclass

import numpy as np

CONFIRMED = 3

WRAP = 1 << 32
"""Of sequence numbers and times on the wire."""

LONGEST_STEP = 1000
"""Samples that may be missing at once before the next must be confirmed."""

TOLERANCE = 0.2
"""By how much the time between two samples may differ from the period announced."""


@dataclass(frozen=True)
class Gap:
    """Samples missing between two that are there.

    Attributes:
        after, before: times of the two [s].
        samples: how many are missing.
    """

    after: float
    before: float
    samples: int


class Timeline:
    """Times of the samples of one run of a rig that speaks the protocol.

    Attributes:
        period: between samples, as the rig announced it [s].
        accepted: samples so far.
        lost: samples missing between those accepted, and before the first of them.
        implausible: samples set aside and never confirmed.
        gaps: found since they were last taken away.
        restarted: the rig's sequence has begun anew; nothing more is accepted.
    """

    def __init__(self, period: float, begin: int) -> None:
        """
        Args:
            period: between samples [s].
            begin: time on the wire of sample 0 [µs].
        """
        self.period = period
        self.accepted = 0
        self.lost = 0
        self.implausible = 0
        self.gaps: list[Gap] = []
        self.restarted = False
        # as if sample -1 had been there
        self._sequence = -1
        self._period = period * 1e6  # [µs], as all times in here
        self._time = -round(self._period)
        self._begin = begin
        self._aside: list[tuple[int, int]] = []
        self._longest_step = LONGEST_STEP

    def interrupted(self) -> None:
        """The line was: any number of samples may be missing before the next."""
        self._longest_step = WRAP // 2

    @property
    def last(self) -> float:
        """Time of the last sample accepted [s]."""
        return self._time / 1e6

    @property
    def next_sequence(self) -> int:
        """Sequence number after the last sample accepted."""
        return self._sequence + 1

    def feed(self, sequence: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places samples in time.

        Args:
            sequence: (n,) sequence numbers as on the wire.
            time: (n,) times as on the wire [µs].

        Returns:
            (m,) indices of the samples that are believed, and their (m,) times since the begin of
            the run [s].
        """
        if self.restarted or not sequence.size:
            return np.empty(0, dtype=int), np.empty(0)
        sequence = sequence.astype(np.int64)
        since = (time.astype(np.int64) - self._begin) % WRAP
        if not self._aside:
            fast = self._all(sequence, since)
            if fast is not None:
                return np.arange(sequence.size), fast / 1e6
        kept, times = [], []
        for i in range(sequence.size):
            placed = self._one(int(sequence[i]), int(since[i]))
            if placed is not None:
                kept.append(i)
                times.append(placed)
        return np.array(kept, dtype=int), np.array(times, dtype=float) / 1e6

    def take_gaps(self) -> list[Gap]:
        """The gaps found since the last call."""
        gaps, self.gaps = self.gaps, []
        return gaps

    def _all(self, sequence: np.ndarray, since: np.ndarray) -> np.ndarray | None:
        """Times [µs] where every sample follows from the one before; None where one does not."""
        steps = np.diff(sequence, prepend=self._sequence % WRAP) % WRAP
        if steps.min() < 1 or steps.max() > LONGEST_STEP:
            return None
        elapsed = np.diff(since, prepend=self._time % WRAP) % WRAP
        off = np.abs(elapsed - steps * self._period)
        if elapsed.min() < 1 or np.any(off > self._slack(steps)):
            return None
        times = self._time + np.cumsum(elapsed)
        if steps.max() > 1:
            before = np.concatenate([[self._time], times[:-1]])
            for i in np.flatnonzero(steps > 1):
                self._gap(int(before[i]), int(times[i]), int(steps[i]) - 1)
        self._sequence += int(steps.sum())
        self._time = int(times[-1])
        self.accepted += sequence.size
        return times

    def _one(self, sequence: int, since: int) -> int | None:
        """Time [µs] of a sample that is believed, or None."""
        step = (sequence - self._sequence) % WRAP
        elapsed = self._elapsed(step, since - self._time)
        if 1 <= step <= self._longest_step and self._agree(step, elapsed):
            self._set_aside_for_good()
            self._accept(step, elapsed)
            return self._time
        if self._aside and not self._follows(sequence, since):
            self._set_aside_for_good()
        self._aside.append((sequence, since))
        if len(self._aside) < CONFIRMED:
            return None
        if not self._agree(step, elapsed):
            elapsed = (since - self._time) % WRAP  # the clock itself has jumped
        self._set_aside_for_good()
        if not (1 <= step < WRAP // 2 and self._forward(step, elapsed)):
            self.restarted = True
            return None
        self.implausible -= 1  # this one is believed
        self._accept(step, elapsed)
        return self._time

    def _forward(self, step: int, elapsed: int) -> bool:
        """Whether the clock went on: beyond half its range only where the sequence says so."""
        return self._agree(step, elapsed) or 0 < elapsed < WRAP // 2

    def _follows(self, sequence: int, since: int) -> bool:
        """Whether a sample follows from the last one set aside."""
        last_sequence, last_since = self._aside[-1]
        step = (sequence - last_sequence) % WRAP
        return 1 <= step <= LONGEST_STEP and self._agree(
            step, self._elapsed(step, since - last_since)
        )

    def _elapsed(self, step: int, difference: int) -> int:
        """Time between two samples [µs], the wraps of the clock told by the sequence numbers."""
        elapsed = difference % WRAP
        return elapsed + WRAP * round((step * self._period - elapsed) / WRAP)

    def _agree(self, step: int, elapsed: int) -> bool:
        return elapsed > 0 and abs(elapsed - step * self._period) <= self._slack(step)

    def _slack(self, step):  # int or array
        return TOLERANCE * step * self._period + 2.0 * self._period

    def _accept(self, step: int, elapsed: int) -> None:
        before = self._time
        self._time += elapsed
        self._sequence += step
        self.accepted += 1
        self._longest_step = LONGEST_STEP
        if step > 1:
            self._gap(before, self._time, step - 1)

    def _gap(self, before: int, after: int, samples: int) -> None:
        self.lost += samples
        self.gaps.append(Gap(max(before, 0) / 1e6, after / 1e6, samples))

    def _set_aside_for_good(self) -> None:
        self.implausible += len(self._aside)
        self._aside.clear()
