"""Which rows of a text stream are believed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition.timeline import LEARNT_FROM, Timeline


def rows(t):
    t = np.asarray(t, dtype=float)
    return np.column_stack([t, np.sin(t), np.cos(t)])


def fed(timeline, t, size=7):
    table = rows(t)
    parts = [timeline.feed_rows(table[i : i + size]) for i in range(0, len(table), size)]
    return np.concatenate(parts)[:, 0]


def test_uniform_rows_pass():
    t = 3.0 + np.arange(100) * 0.004
    timeline = Timeline()
    np.testing.assert_array_equal(fed(timeline, t), t)
    assert (timeline.accepted, timeline.lost, timeline.implausible) == (100, 0, 0)


@pytest.mark.parametrize(("rate", "unit"), [(2000.0, "milliseconds"), (500.0, "milliseconds")])
def test_decimals_of_a_millisecond_are_no_seconds(rate, unit):
    seconds = np.arange(4000) / rate
    timeline, table = Timeline(), rows(np.round(1e3 * seconds, 1))
    chunk = int(0.03 * rate)
    parts = [
        timeline.feed_rows(table[i : i + chunk], 50.0 + (i + chunk) / rate)
        for i in range(0, len(table), chunk)
    ]
    assert timeline.unit == unit
    np.testing.assert_allclose(np.concatenate(parts)[:, 0], seconds, atol=1e-9)


def test_a_gap_stays_one():
    t = np.delete(np.arange(200) * 0.004, [50, 51, 120, *range(150, 190)])
    timeline = Timeline()
    np.testing.assert_array_equal(fed(timeline, t), t)
    assert timeline.lost == 43
    assert [gap.samples for gap in timeline.take_gaps()] == [2, 1, 40]


def test_damaged_times_are_left_out():
    t = np.arange(100) * 0.004
    damaged = t.copy()
    damaged[[20, 40, 60, 61]] = [0.8, 4.16, 0.1, 0.116]
    timeline = Timeline()
    np.testing.assert_array_equal(fed(timeline, damaged), np.delete(t, [20, 40, 60, 61]))
    assert timeline.implausible == 4
    assert not timeline.restarted


def test_a_rig_that_begins_anew():
    t = np.arange(100) * 0.004
    timeline = Timeline()
    fed(timeline, t)
    assert fed(timeline, t).size == 0
    assert timeline.restarted


def test_a_stream_that_ends_at_once():
    timeline = Timeline()
    assert fed(timeline, [0.0, 0.1, 0.1, 0.3]).size == 0
    np.testing.assert_array_equal(timeline.rest()[:, 0], [0.0, 0.1, 0.3])
    assert Timeline().rest() is None


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=60), st.integers(1, 9))
def test_times_always_rise(times, size):
    timeline = Timeline()
    t = np.concatenate([np.arange(LEARNT_FROM) * 0.5, times])
    got = fed(timeline, t, size)
    assert np.all(np.diff(got) > 0.0)


@given(st.lists(st.floats(-1e6, 1e6, allow_subnormal=True), min_size=1, max_size=60))
def test_no_count_is_negative(t):
    timeline = Timeline()
    fed(timeline, t)
    assert min(timeline.lost, timeline.accepted, timeline.implausible) >= 0
    assert sum(gap.samples for gap in timeline.take_gaps()) == timeline.lost
