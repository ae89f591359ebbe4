"""Tally of hostile inputs: refused in one sentence, done, or a fault of ours."""

import signal
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from tp_jax.errors import InputError

LONGEST = 60
"""Seconds after which an input hangs."""

MOST_SHOWN = 5


class Hang(BaseException):
    """An input took longer than `LONGEST`."""


class Wrong(AssertionError):
    """An input was taken, and what came of it is not what it has to be."""


@dataclass
class Row:
    """One door: inputs tried, refused, done; faults by what went wrong, and the slowest [s]."""

    tried: int = 0
    refused: int = 0
    done: int = 0
    slowest: float = 0.0
    faults: dict[str, int] = field(default_factory=dict)

    def fault(self, said: str) -> None:
        self.faults[said] = self.faults.get(said, 0) + 1


class Tally:
    """Rows by the door's name, in the order they were attacked."""

    def __init__(self) -> None:
        self.rows: dict[str, Row] = {}

    def attempt(
        self,
        door: str,
        work: Callable[[], object],
        about: object = "",
        longest: float | None = None,
    ) -> None:
        """Does the work and counts what became of it.

        Args:
            door: that is tried.
            work: returns where the input was taken, raises InputError where it was refused.
            about: reported with a fault, so that it can be had again.
            longest: seconds after which it hangs, if not `LONGEST`.
        """
        row = self.rows.setdefault(door, Row())
        row.tried += 1
        begun = time.monotonic()
        try:
            with limited(LONGEST if longest is None else longest):
                work()
        except InputError as fault:
            row.refused += 1
            if "\n" in str(fault) or not str(fault).strip():
                row.fault(f"not one sentence: {str(fault)[:80]!r}")
        except Hang:
            row.fault(f"hangs: {about!s:.160}")
        except Exception as fault:
            row.fault(f"{told(fault)} ({about!s:.160})")
        else:
            row.done += 1
        row.slowest = max(row.slowest, time.monotonic() - begun)

    @property
    def faults(self) -> int:
        """All of them."""
        return sum(sum(row.faults.values()) for row in self.rows.values())

    def lines(self) -> list[str]:
        """The table, and what the faults are."""
        head = f"{'door':32}{'tried':>8}{'refused':>9}{'done':>8}{'faults':>8}{'slowest s':>11}"
        out = [head]
        total = Row()
        for door, row in self.rows.items():
            out.append(_line(door, row))
            for name in ("tried", "refused", "done"):
                setattr(total, name, getattr(total, name) + getattr(row, name))
            total.slowest = max(total.slowest, row.slowest)
            total.faults[door] = sum(row.faults.values())
        out.append(_line("all", total))
        for door, row in self.rows.items():
            for said, times in list(row.faults.items())[:MOST_SHOWN]:
                out.append(f"fault, {door}, {times} times: {said}")
        return out


def _line(door: str, row: Row) -> str:
    faults = sum(row.faults.values())
    return f"{door:32}{row.tried:8}{row.refused:9}{row.done:8}{faults:8}{row.slowest:11.2f}"


def told(fault: Exception) -> str:
    """The exception, and where in the package it arose."""
    ours = [f for f in traceback.extract_tb(fault.__traceback__) if "tp_jax" in f.filename]
    place = ""
    if ours:
        place = f" at {'/'.join(ours[-1].filename.split('/')[-2:])}:{ours[-1].lineno}"
    return f"{type(fault).__name__}: {' '.join(str(fault).split())[:120]}{place}"


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises `Hang` within it after so many seconds; the main thread only."""

    def stop(*_: object) -> None:
        raise Hang

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
