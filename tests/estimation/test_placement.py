"""Windows are put into lanes so that all lanes take about as long, and none twice."""

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.placement import SHORTEST, Experience, expected_steps, longest, place
from tp_jax.estimation.windows import Prepared, Windows

WIDTH = 8


def windows(counts_by_recording):
    recording = np.repeat(np.arange(len(counts_by_recording)), list(map(len, counts_by_recording)))
    count = np.concatenate(counts_by_recording)
    first = np.concatenate([np.cumsum(c) - c for c in counts_by_recording])
    return Windows(recording, first, count, 1.0)


def loads(places, cost):
    lanes = places[:, 0] * WIDTH + places[:, 1]
    return np.bincount(lanes, cost, minlength=WIDTH * (places[:, 0].max() + 1))


@pytest.mark.parametrize("size", [9, 50, 210])
def test_every_window_has_a_place_of_its_own(size):
    rng = np.random.default_rng(size)
    w = windows([np.full(2500 // size, size)] * 5)
    places = place(w, rng.gamma(2.0, size=w.n), 1024, WIDTH)
    taken = set()
    for (block, lane, at, rank), count, recording in zip(places, w.count, w.recording, strict=True):
        assert 0 <= lane < WIDTH
        assert at + count <= 1024
        assert rank < 1024 // SHORTEST
        mine = {(block, lane, at + i) for i in range(count)}
        assert not mine & taken
        taken |= mine
        same = (places[:, 0] == block) & (places[:, 1] == lane)
        assert set(w.recording[same]) == {recording}
        before = same & (places[:, 2] < at)
        assert before.sum() == rank
        assert w.count[before].sum() == at


def test_blocks_end_together():
    """What a block takes is its slowest lane."""
    w = windows([np.full(60, 40)] * 5)
    cost = np.where(w.recording < 2, 4.0, 1.0)
    found = loads(place(w, cost, 1024, WIDTH), cost).reshape(-1, WIDTH)
    assert WIDTH * found.max(axis=1).sum() < 1.3 * cost.sum()


def test_few_windows_are_spread_over_all_lanes():
    w = windows([np.full(12, 200)])
    found = loads(place(w, np.ones(12), 1024, WIDTH), np.ones(12))
    assert found.size == WIDTH
    assert found.max() == 2.0


def test_many_tiny_windows_do_not_crowd_a_lane():
    w = windows([np.full(400, 2)])
    places = place(w, np.ones(400), 1024, WIDTH)
    assert places[:, 3].max() < 1024 // SHORTEST


def test_more_blocks_than_needed_where_one_recording_takes_most():
    """Else its windows queue up in the few lanes that its samples need, and one thread waits."""
    w = windows([np.full(10, 250)] * 5)
    cost = np.where(w.recording == 4, 750.0, 220.0)
    needed = -(-5 * 3 // WIDTH)
    found = loads(place(w, cost, 1024, WIDTH), cost).reshape(-1, WIDTH).max(axis=1)
    assert found.size > needed
    assert found.max() == 750.0
    assert WIDTH * found.sum() < 1.25 * cost.sum()


def test_no_more_blocks_than_needed_where_all_take_the_same():
    w = windows([np.full(4, 250)] * 16)
    assert place(w, np.full(w.n, 200.0), 1024, WIDTH)[:, 0].max() == 1


def test_what_was_seen_is_expected_and_scales_the_rest():
    t = np.arange(400) * 0.004
    one = standing_in(
        Prepared,
        t=t,
        channels=np.array([True, False]),
        smooth=np.ones((400, 4)),
        smooth_sd=np.ones((400, 4)),
    )
    w = windows([np.full(4, 100)])
    guess, experience = expected_steps(w, [one]), Experience()
    np.testing.assert_array_equal(experience.expected(w, [one]), guess)
    some = Windows(w.recording[:2], w.first[:2], w.count[:2], 1.0)
    experience.learn(some, 3.0 * guess[:2] + [0.0, 2.0])
    found = experience.expected(w, [one])
    np.testing.assert_array_equal(found[:2], 3.0 * guess[:2] + [0.0, 2.0])
    np.testing.assert_allclose(found[2:], found[:2].mean())


def test_blocks_take_their_slowest_lanes_together():
    places = np.array([[0, 0, 0, 0], [0, 1, 0, 0], [0, 1, 9, 1], [1, 0, 0, 0]])
    assert longest(places, np.array([5.0, 2.0, 4.0, 7.0])) == 13.0
