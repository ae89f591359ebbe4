"""Jobs by two threads."""

import threading

import pytest

from tp_jax.estimation.two_threads import by_two


@pytest.mark.parametrize("many", [0, 1, 2, 7])
def test_every_job_in_order(many):
    assert by_two(lambda job: 10 * job, range(many)) == [10 * job for job in range(many)]


def test_two_at_once():
    together = threading.Barrier(2, timeout=30.0)
    assert by_two(lambda _: together.wait() < 2, "ab") == [True, True]


def test_a_single_job_needs_no_thread_of_its_own():
    assert by_two(lambda _: threading.current_thread(), [0]) == [threading.current_thread()]


@pytest.mark.parametrize("bad", [0, 1, 2])
def test_a_fault_is_the_callers(bad):
    def run(job):
        if job == bad:
            raise IndexError("on purpose")
        return job

    with pytest.raises(IndexError, match="on purpose"):
        by_two(run, [0, 1, 2])
