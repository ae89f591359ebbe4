"""What is said of programs that are being compiled."""

import pytest

from tp_jax import _compiling


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    monkeypatch.setattr(_compiling, "_begun", {})
    monkeypatch.setattr(_compiling, "_compiled", 0)
    return Clock()


def test_what_takes_long_is_said(clock):
    with _compiling.noted(clock):
        clock.now = 1.0
        assert _compiling.described(clock) == ""
        clock.now = 5.0
        assert _compiling.described(clock) == "compiling program 1, once on this machine"
    assert _compiling.described(clock) == ""
    with _compiling.noted(clock), _compiling.noted(clock):
        clock.now = 10.0
        assert _compiling.described(clock) == "compiling programs 2 to 3, once on this machine"


def test_what_was_loaded_does_not_count(clock):
    with _compiling.noted(clock):
        clock.now = 1.0
    with _compiling.noted(clock):
        clock.now = 9.0
    with _compiling.noted(clock):
        clock.now = 20.0
        assert _compiling.described(clock).startswith("compiling program 2,")
