"""Programs that are being compiled just now, for whoever shows progress.

A first diagnosis on a machine compiles for minutes, in the midst of stages whose names say nothing
of it.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SLOW = 3.0
"""Seconds from which on a program is being compiled; what is in the cache is loaded in one."""

_lock = threading.Lock()
_begun: dict[object, float] = {}
_compiled = 0


@contextmanager
def noted(now: Callable[[], float] = time.monotonic) -> Iterator[None]:
    """Within the block one more program is made ready."""
    global _compiled
    program = object()
    with _lock:
        _begun[program] = now()
    try:
        yield
    finally:
        with _lock:
            _compiled += now() - _begun.pop(program) > SLOW


def described(now: Callable[[], float] = time.monotonic) -> str:
    """`compiling program 3, once on this machine`; empty where nothing is compiled."""
    with _lock:
        going = sum(now() - begun > SLOW for begun in _begun.values())
        first, last = _compiled + 1, _compiled + going
    if not going:
        return ""
    which = f"program {first}" if going == 1 else f"programs {first} to {last}"
    return f"compiling {which}, once on this machine"
