"""One processor for each worker: XLA splits sums by the number of threads that it may use.

With one it computes the same bits on every machine of a kind, whatever executor hands it work.
"""

import os
import socket

_held: list[socket.socket] = []  # of this process, as long as it lives


def available() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def take_one() -> None:
    """Keeps this process to one processor, which no other worker has if one is free.

    A name in Linux's abstract sockets says that a processor is taken; the system frees it when the
    process ends, however it ends. Elsewhere nothing happens: other systems do not let a process
    choose.
    """
    if _held or not hasattr(os, "sched_setaffinity"):
        return
    allowed = sorted(os.sched_getaffinity(0))
    mine = next((each for each in allowed if _taken(each)), allowed[os.getpid() % len(allowed)])
    os.sched_setaffinity(0, {mine})


def _taken(processor: int) -> bool:
    """True if the processor was free and is this process's from now on."""
    name = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        name.bind(f"\0tp-jax/{os.getuid()}/processor-{processor}")
    except OSError:
        name.close()
        return False
    _held.append(name)
    return True
