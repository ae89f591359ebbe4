"""Linear algebra in one thread, and as many as before afterwards."""

import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_info, threadpool_limits

from tp_jax._blas import one_blas_thread


def threads() -> list[int]:
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


def test_one_thread_within_and_what_was_set_afterwards():
    assert np.linalg.norm(scipy.linalg.inv(np.eye(3)) - np.eye(3)) == 0.0  # both are loaded
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        with one_blas_thread():
            assert set(threads()) <= {1}
        assert threads() == before


def test_functions_keep_their_name_and_their_words():
    @one_blas_thread()
    def fitted(a: int) -> list[int]:
        """Fits."""
        return [*threads(), a]

    assert fitted.__doc__ == "Fits."
    assert set(fitted(1)) == {1}
