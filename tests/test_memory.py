"""Memory is given back where the system's C library knows how, and elsewhere nothing happens."""

import ctypes
import platform

import numpy as np
import pytest

from tp_jax import _memory


@pytest.fixture(autouse=True)
def afresh():
    _memory._trim.cache_clear()
    yield
    _memory._trim.cache_clear()


def resident() -> int:
    """Pages of this process in memory."""
    with open("/proc/self/statm") as f:
        return int(f.read().split()[1])


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="needs glibc")
def test_what_was_freed_in_small_pieces_is_given_back():
    pieces = [np.ones(10_000) for _ in range(2_000)]  # 160 MB
    last = np.ones(10_000)  # keeps the heap from shrinking by itself
    pieces.clear()
    before = resident()
    _memory.release()
    assert resident() <= before
    assert last[0] == 1.0


@pytest.mark.parametrize("fault", [OSError, TypeError])
def test_nothing_where_there_is_no_such_library(monkeypatch, fault):
    def library(_):
        raise fault

    monkeypatch.setattr(ctypes, "CDLL", library)
    _memory.release()


def test_nothing_where_the_library_has_no_such_function(monkeypatch):
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    _memory.release()
