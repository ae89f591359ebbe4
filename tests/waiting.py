"""Waiting for conditions instead of seconds, and processes that no test leaves behind."""

import contextlib
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

PATIENCE = 120.0
"""Seconds after which a condition counts as never met, on a machine however busy."""


def until(condition: Callable[[], Any], patience: float = PATIENCE) -> None:
    """Waits until a condition holds."""
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "the condition was never met"
        time.sleep(0.01)


HEEDING = (
    "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_DFL); "
    "os.execv(sys.argv[1], sys.argv[1:])"
)


@contextlib.contextmanager
def running(words: list[str], **options: Any) -> Iterator[subprocess.Popen]:
    """A process that is gone at the end, whatever becomes of the test.

    What a shell runs in the background ignores interrupts, and so do tests there and their
    processes: this one heeds them. (It sees to that itself; a function called between fork and exec
    would fork a process that has JAX's threads.)
    """
    with subprocess.Popen([sys.executable, "-c", HEEDING, *words], **options) as process:
        try:
            yield process
        finally:
            process.kill()
