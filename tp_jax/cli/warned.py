"""Warnings while a command runs: the package's own as one line, those of libraries not at all."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from tp_jax.errors import Notice


@contextmanager
def only_notices(*, debug: bool) -> Iterator[None]:
    """Within it a `Notice` is one sentence on standard error; with `debug` the others show too.

    What a warning of SciPy or NumPy means for the user, a result or a fault says; the warning
    itself names lines of code that they have not written. Filters stay as they are, so that
    `-W error` still makes errors of them.
    """
    before = warnings.showwarning

    def show(message, category, filename, lineno, file=None, line=None) -> None:
        if issubclass(category, Notice):
            print(f"tp-jax: {' '.join(str(message).split())}", file=sys.stderr)
        elif debug:
            before(message, category, filename, lineno, file, line)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = before
