"""An executor of workers with one piece in hand each, who are replaced when they die.

`ProcessPoolExecutor` gives up all its pieces when one process of it dies. Here each worker is on
its own, so that its death costs one piece, which the seam submits again.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from threading import Lock
from typing import Any, Protocol, runtime_checkable


class Refused(RuntimeError):
    """An executor takes no more work for now; the text says why."""


@contextmanager
def ended(executor: Executor) -> Iterator[Executor]:
    """The executor; its work is waited for, or given up where the block ends by an exception."""
    try:
        yield executor
    except BaseException:
        executor.shutdown(cancel_futures=True)
        raise
    executor.shutdown()


@runtime_checkable
class Worker(Protocol):
    """A process, here or elsewhere, that stays for many pieces."""

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future:
        """Begins work; raises what `lost` knows where the worker is dead already."""
        ...

    def lost(self, fault: BaseException) -> bool:
        """True if the fault says that the worker is dead, rather than that its work failed."""
        ...

    def end(self, *, at_once: bool) -> None:
        """Ends the worker; at once: with work in hand."""
        ...


class Workers(Executor):
    """Executor of so many workers; a piece goes to the one with the least in hand."""

    def __init__(
        self, make: Callable[[], Worker], count: int, pieces_per_worker: int | None = None
    ) -> None:
        self._lock = Lock()
        self._places = [_Place(make, pieces_per_worker) for _ in range(count)]

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        if kwargs:
            raise TypeError("Workers take positional arguments only.")
        with self._lock:
            return min(self._places, key=_Place.in_hand).submit(fn, *args)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the workers; they finish what they have in hand unless it is to be cancelled."""
        with self._lock:
            for place in self._places:
                if wait or cancel_futures:
                    place.end(at_once=cancel_futures)


class _Place:
    """Place of one worker at a time."""

    def __init__(self, make: Callable[[], Worker], pieces_per_worker: int | None) -> None:
        self._make, self._last = make, pieces_per_worker
        self._worker: Worker | None = None
        self._futures: list[Future] = []
        self._begun = 0

    def in_hand(self) -> int:
        """Pieces begun and not ended; a worker who died of one that ended is replaced."""
        ended = [future for future in self._futures if future.done()]
        self._futures = [future for future in self._futures if not future.done()]
        if self._worker is not None:
            faults = [f.exception() for f in ended if not f.cancelled()]
            if any(fault is not None and self._worker.lost(fault) for fault in faults):
                self.end(at_once=True)
        return len(self._futures)

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future:
        if self._last is not None and self._begun >= self._last and not self._futures:
            self.end(at_once=False)
        try:
            future = self._current().submit(work, *arguments)
        except Exception as fault:
            if self._worker is None or not self._worker.lost(fault):
                raise
            self.end(at_once=True)  # it died between two pieces
            future = self._current().submit(work, *arguments)
        self._begun += 1
        self._futures.append(future)
        return future

    def _current(self) -> Worker:
        if self._worker is None:
            self._worker, self._begun = self._make(), 0
        return self._worker

    def end(self, *, at_once: bool) -> None:
        if self._worker is not None:
            self._worker.end(at_once=at_once)
        self._worker, self._futures = None, []
