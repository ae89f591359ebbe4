"""Processes of this machine that stay for many pieces: what they have compiled is not lost.

Fresh processes rather than forks: a fork of a process with threads, as JAX has them, may hang.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from typing import Any

from tp_jax.executors.workers import Workers, ended


@contextmanager
def opened(workers: int, pieces_per_worker: int | None = None) -> Iterator[Executor]:
    """Opens so many processes; where the block ends by an exception they are killed."""
    with ended(Workers(LocalProcess, workers, pieces_per_worker)) as executor:
        yield executor


class LocalProcess:
    """A worker: one process."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(1, context, _begin)
        self._pid = self._pool.submit(os.getpid)

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future:
        return self._pool.submit(work, *arguments)

    def lost(self, fault: BaseException) -> bool:
        return isinstance(fault, BrokenExecutor)

    def end(self, *, at_once: bool) -> None:
        if at_once:
            with suppress(BrokenExecutor):  # dead already
                pid = self._pid.result()
                for child in multiprocessing.active_children():
                    if child.pid == pid:
                        child.kill()
        self._pool.shutdown(cancel_futures=at_once)


def _begin() -> None:
    """Begins a process: an interrupt is for the one that started it, and it ends with that one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, name="tp-jax-parent", daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)  # nobody is left to take a result
