"""Number of threads that the linear algebra of NumPy and SciPy takes."""

import contextlib
import os
from collections.abc import Iterator

_VARIABLE = "KMP_DUPLICATE_LIB_OK"
_before = os.environ.get(_VARIABLE)
from threadpoolctl import threadpool_limits  # noqa: E402

if _before is None:  # threadpoolctl sets it for Intel's OpenMP; a program's environment is its own
    os.environ.pop(_VARIABLE, None)


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Within it, or in a function that it decorates, BLAS computes in one thread.

    The package's matrices have at most a few hundred rows. With several threads OpenBLAS is no
    faster at these, and its threads spin for a while after each product, waiting for the next: an
    eighth to a fifth of a diagnosis' CPU time with two threads. Holds for the whole process; what
    was set before is restored.
    """
    with threadpool_limits(limits=1, user_api="blas"):
        yield
