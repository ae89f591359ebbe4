"""Waiting for conditions instead of seconds, and processes that no test leaves behind."""

import contextlib
import signal
import subprocess
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


@contextlib.contextmanager
def running(words: list[str], **options: Any) -> Iterator[subprocess.Popen]:
    """A process that is gone at the end, whatever becomes of the test.

    What a shell runs in the background ignores interrupts, and so do tests there and their
    processes: this one heeds them.
    """
    heeding = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731
    with subprocess.Popen(words, preexec_fn=heeding, **options) as process:
        try:
            yield process
        finally:
            process.kill()
