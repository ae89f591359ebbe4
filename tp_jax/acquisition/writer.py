"""The recording's file, written as the samples come.

Every block of rows goes to the operating system at once and whole: all that was handed over is safe
from the death of this process. A thread of its own asks the system to put it on the disk once a
second, and writes what stands beside it, so that a slow disk never makes the reader wait.
"""

import os
import queue
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from tp_jax._files import replaced
from tp_jax.errors import InputError

SYNC_PERIOD = 1.0  # seconds between two requests to put the file on the disk


class CsvWriter:
    """Appends rows to a new file of the contract's format, 17 significant digits; counts `rows`."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        """Makes the file, or raises InputError, and writes the header."""
        self.rows = 0
        self._line = ",".join(["%.17g"] * len(names)) + "\n"
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            # O_EXCL: nobody else's file is ever written over, made a moment ago or not
            self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o666)
        except FileExistsError:
            raise InputError(already_there(path)) from None
        except OSError as fault:
            raise InputError(f"Cannot write {path}: {fault.strerror}.") from fault
        try:
            self._append((",".join(names) + "\n").encode())
        except OSError as fault:
            os.close(self._fd)
            path.unlink(missing_ok=True)  # it holds nothing, and the name is free for another try
            raise InputError(f"Cannot write {path}: {fault.strerror}.") from fault
        self._closed = False
        self._beside: queue.SimpleQueue[Callable[[], object] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._sync, name="tp-jax-sync", daemon=True)
        self._thread.start()

    def write(self, columns: np.ndarray) -> None:
        """Appends (n, columns) rows; raises OSError where the disk is full or gone."""
        self._append((self._line * len(columns) % tuple(columns.ravel().tolist())).encode())
        self.rows += len(columns)

    def _append(self, text: bytes) -> None:
        """Writes all of it or nothing: a number cut in two would be read as another number."""
        before = os.fstat(self._fd).st_size
        block = memoryview(text)
        try:
            while block:  # a pipe or a full disk may take a part
                block = block[os.write(self._fd, block) :]
        except OSError:
            with suppress(OSError):  # a pipe takes nothing back
                os.ftruncate(self._fd, before)
            raise

    def beside(self, job: Callable[[], object]) -> None:
        """Has the thread do something with the disk, unless it is still at the last such job."""
        if self._beside.empty():
            self._beside.put(job)

    def close(self) -> None:
        """Puts all on the disk, and waits for the thread."""
        if self._closed:
            return
        self._closed = True
        self._beside.put(None)
        self._thread.join()
        try:
            os.fsync(self._fd)
        finally:
            os.close(self._fd)

    def _sync(self) -> None:
        while True:
            try:
                with suppress(queue.Empty):
                    job = self._beside.get(timeout=SYNC_PERIOD)
                    if job is None:
                        return
                    job()
                os.fsync(self._fd)
            except OSError:
                return  # close tells, or whoever writes the last of what stands beside


def already_there(path: Path) -> str:
    """The sentence for a file that must not be written over."""
    return f"There is a file {path} already; give another name or move it away."


def scale_time(path: Path, factor: float) -> None:
    """Multiplies the times of a recording by a factor; the file is replaced at once and whole."""
    with replaced(path) as part, path.open("rb") as source, part.open("wb") as target:
        target.write(source.readline())
        for line in source:
            time, _, rest = line.partition(b",")
            target.write(b"%.17g,%s" % (float(time) * factor, rest))
