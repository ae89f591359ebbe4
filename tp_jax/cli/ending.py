"""Ending with the program that started this one, however that one ends."""

import os
import signal
import threading

GRACE = 5.0
"""Seconds for a command to end by itself: a compiled program does not hear of an interrupt."""

INTERRUPTED = 130
"""The exit code of a command that was interrupted."""


def end_with_standard_input() -> None:
    """Interrupts this process once its standard input closes; after `GRACE` it ends at once.

    The system closes it even where the other program was killed.
    """
    threading.Thread(target=_wait, name="tp-jax-ending", daemon=True).start()


def _wait() -> None:
    while os.read(0, 4096):  # not sys.stdin, whose lock would keep the interpreter from ending
        pass
    os.kill(os.getpid(), signal.SIGINT)
    threading.Event().wait(GRACE)
    os._exit(INTERRUPTED)
