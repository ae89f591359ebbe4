"""What is told of a recording: counts of what is missing."""

from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition.port import Port
from tp_jax.acquisition.run_log import RunLog, Settings
from tp_jax.acquisition.streams import Stream
from tp_jax.acquisition.timeline import Timeline

PERIOD = 1000  # µs


def lost(steps, jumps, duration, size=5):
    """Samples lost of a run, and its timeline: steps of the sequence, jumps of the clock [µs]."""
    timeline = Timeline(1e-6 * PERIOD, 0)
    stream = Mock(spec=Stream, timeline=timeline, kind="frames", names=("t", "phi1"))
    log = RunLog(Path("run.csv"), Mock(spec=Port), stream, Settings(duration))
    sequence = np.cumsum(steps)
    times = sequence * PERIOD + np.cumsum(jumps)
    for i in range(0, sequence.size, size):
        part = slice(i, i + size)
        _, t = timeline.feed(sequence[part] % 2**32, times[part] % 2**32)
        log.note_gaps()
        log._cut += int((t > duration + 0.25e-6 * PERIOD).sum())
    return log._lost(), timeline


def test_what_is_missing_beyond_the_end_is_not_counted():
    steps = np.ones(120, int)
    steps[[0, 20, 100]] = 0, 4, 11  # three are missing inside, ten over the end
    found, timeline = lost(steps, 0 * steps, duration=0.105)
    assert timeline.lost == 13
    assert found == 3 + 3


@pytest.mark.parametrize("jump", [10_000, 860_000, 2_000_000_000])
def test_a_clock_that_jumps_over_the_end(jump):
    """By the times hundreds are missing, by the sequence two: there was -859 of them once."""
    steps, jumps = np.ones(120, int), np.zeros(120, int)
    steps[[0, 20]] = 0, 4
    jumps[100] = jump
    found, timeline = lost(steps, jumps, duration=0.106)
    assert 3 <= found <= timeline.lost == 5


@given(
    st.lists(st.integers(1, 40), min_size=5, max_size=60),
    st.lists(st.tuples(st.integers(0, 59), st.integers(-(10**6), 10**9)), max_size=4),
    st.floats(1e-3, 2.0),
)
def test_no_count_is_negative(steps, jumps, duration):
    moved = np.zeros(len(steps), int)
    for at, by in jumps:
        moved[at % len(steps)] += by
    found, timeline = lost(np.array(steps), moved, duration)
    assert 0 <= found <= timeline.lost
