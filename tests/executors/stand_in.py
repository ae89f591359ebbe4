"""Pieces that cost next to nothing, and a hand that kills workers."""

import os
import signal
import threading
import time
from pathlib import Path

from tp_jax.errors import InputError
from tp_jax.executors import Piece

CPU_S = 0.25
"""Of a piece [s]."""


def summed(number: int, begun: Path) -> dict[str, float]:
    """Sums for a while; says in a file that it has begun, with its process."""
    with (begun / f"{number}.txt").open("a") as file:
        file.write(f"{os.getpid()}\n")
    total, until = 0.0, time.process_time() + CPU_S
    for i in range(1, 200_000):
        total += 1.0 / (number + i) ** 1.5
    while time.process_time() < until:
        pass
    return {"number": number, "total": total}


def failing(number: int) -> int:
    """Works for even numbers."""
    if number % 2:
        raise ValueError(f"{number} is odd")
    return number


def asked_for_more() -> None:
    raise InputError("The file run.csv has no column t; add one.")


def ends_itself() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def where() -> tuple[int, int]:
    """Process, and processors it may use."""
    return os.getpid(), len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def some_pieces(count: int, begun: Path) -> list[Piece]:
    begun.mkdir(exist_ok=True)
    return [Piece(f"piece-{i}", (i, begun)) for i in range(count)]


def begun_times(begun: Path) -> dict[int, int]:
    """How often each piece was begun."""
    return {int(f.stem): len(f.read_text().split()) for f in begun.glob("*.txt")}


class Hand:
    """Kills the process that began a piece last, every so many seconds, so many times."""

    def __init__(self, begun: Path, times: int, every_s: float = 1.5) -> None:
        self.begun, self.times, self.every_s = begun, times, every_s
        self.killed: list[int] = []
        self._thread = threading.Thread(target=self._strike, daemon=True)

    def __enter__(self) -> "Hand":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.times = 0
        self._thread.join()

    def _strike(self) -> None:
        while len(self.killed) < self.times:
            files = sorted(self.begun.glob("*.txt"), key=lambda f: f.stat().st_mtime_ns)
            pids = [int(pid) for f in files for pid in f.read_text().split()]
            new = [pid for pid in pids if pid not in self.killed]
            if new:
                try:
                    os.kill(new[-1], signal.SIGKILL)
                except ProcessLookupError:
                    pass
                else:
                    self.killed.append(new[-1])
            time.sleep(self.every_s if new else 0.05)
