"""Pieces that cost next to nothing."""

import os
import signal
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
