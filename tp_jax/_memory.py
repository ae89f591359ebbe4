"""Memory that a compiler leaves behind."""

import ctypes
import functools
from collections.abc import Callable


def release() -> None:
    """Gives freed memory back to the system, where its C library can (glibc).

    Compiling or loading a program takes hundreds of megabytes for a moment, in many small pieces,
    and glibc keeps them for later; but the next program is loaded by another thread, which takes
    its own.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@functools.cache
def _trim() -> Callable[[int], int] | None:
    try:
        return ctypes.CDLL(None).malloc_trim
    except (OSError, AttributeError, TypeError):  # TypeError: Windows knows no library None
        return None
