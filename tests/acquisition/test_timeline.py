"""Times of samples: wraps, gaps, frames that cannot be, and clocks that begin anew."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition.timeline import LONGEST_STEP, Timeline

PERIOD = 1000  # µs
WRAP = 2**32


def feed(timeline, sequence, time=None):
    sequence = np.asarray(sequence)
    time = sequence * PERIOD + timeline._begin if time is None else np.asarray(time)
    return timeline.feed((sequence % WRAP).astype("<u4"), (np.asarray(time) % WRAP).astype("<u4"))


def made(begin=0):
    return Timeline(1e-3, begin)


def test_uniform_sampling_stays_uniform():
    timeline = made(begin=WRAP - 5000)  # the clock wraps at once
    kept, t = feed(timeline, np.arange(100))
    np.testing.assert_array_equal(kept, np.arange(100))
    np.testing.assert_array_equal(t, np.arange(100) / 1000)
    assert (timeline.accepted, timeline.lost, timeline.last) == (100, 0, 0.099)


def test_hours_of_it():
    timeline, last = made(begin=77), -1.0
    for first in range(0, 3 * 4_294_968, 900):  # three wraps of the clock, with gaps
        _, t = feed(timeline, np.arange(first, first + 450))
        assert t[0] > last
        last = t[-1]
    assert last == (first + 449) / 1000
    assert timeline.lost == first // 2


@given(st.sets(st.integers(0, 2000), min_size=1), st.integers(1, 300))
def test_what_is_lost_is_counted(present, size):
    there, timeline, got = np.array(sorted(present)), made(), []
    for i in range(0, there.size, size):
        got += list(feed(timeline, there[i : i + size])[1])
    if max(np.diff(there, prepend=-1)) <= LONGEST_STEP:
        assert got == [n / 1000 for n in there]
        assert timeline.lost == there[-1] + 1 - there.size
        gaps = timeline.take_gaps()
        assert sum(gap.samples for gap in gaps) == timeline.lost
        assert timeline.take_gaps() == []


def test_a_gap():
    timeline = made()
    feed(timeline, [0, 1, 5, 6])
    (gap,) = timeline.take_gaps()
    assert (gap.after, gap.before, gap.samples) == (0.001, 0.005, 3)


@pytest.mark.parametrize("sequence", [3, 8, 500_000, WRAP - 3])
@pytest.mark.parametrize("time", [0, 3000, 4_000_000_000])
def test_one_frame_that_cannot_be_changes_nothing(sequence, time):
    timeline = made()
    feed(timeline, np.arange(10))
    assert feed(timeline, [sequence], [time])[0].size == 0
    _, t = feed(timeline, np.arange(10, 20))
    np.testing.assert_array_equal(t, np.arange(10, 20) / 1000)
    assert (timeline.lost, timeline.implausible, timeline.restarted) == (0, 1, False)


def test_a_wrong_frame_inside_a_batch():
    timeline = made()
    kept, t = feed(timeline, [0, 1, 2, 3, 4], [0, 1000, 7_777_777, 3000, 4000])
    np.testing.assert_array_equal(kept, [0, 1, 3, 4])
    np.testing.assert_array_equal(t, [0.0, 0.001, 0.003, 0.004])
    assert (timeline.lost, timeline.implausible) == (1, 1)


def test_a_repeated_frame_is_written_once():
    timeline = made()
    kept, _ = feed(timeline, [0, 1, 1, 2])
    np.testing.assert_array_equal(kept, [0, 1, 3])


def test_a_long_gap_is_believed_when_it_is_confirmed():
    timeline = made()
    feed(timeline, np.arange(10))
    _, t = feed(timeline, np.arange(50_000, 50_010))
    np.testing.assert_array_equal(t, np.arange(50_002, 50_010) / 1000)
    assert timeline.lost == 50_002 - 10
    timeline.interrupted()  # after an unplugging it is expected
    assert feed(timeline, [90_000])[1] == 90.0
    assert not timeline.restarted


def test_a_clock_that_jumps_by_itself():
    timeline = made()
    feed(timeline, np.arange(10))
    _, t = feed(timeline, np.arange(10, 20), np.arange(10, 20) * PERIOD + 1_000_000)
    np.testing.assert_array_equal(t, 1.0 + np.arange(12, 20) / 1000)
    assert timeline.lost == 2
    assert not timeline.restarted


def test_a_rig_that_begins_anew():
    timeline = made()
    feed(timeline, np.arange(100))
    assert feed(timeline, np.arange(10))[0].size == 0
    assert timeline.restarted
    assert feed(timeline, np.arange(100, 110))[0].size == 0  # nothing more


@given(
    st.lists(
        st.tuples(st.integers(0, WRAP - 1), st.integers(0, WRAP - 1)), min_size=1, max_size=40
    ),
    st.integers(1, 9),
)
def test_times_always_rise(frames, size):
    timeline, times = made(), [-1.0]
    feed(timeline, np.arange(5))
    times.append(0.004)
    array = np.array(frames)
    for i in range(0, len(frames), size):
        times += list(feed(timeline, array[i : i + size, 0], array[i : i + size, 1])[1])
    assert np.all(np.diff(times) > 0.0)
