"""Gaps are found where samples were lost, and nowhere else."""

from itertools import pairwise

import numpy as np
import pytest

from tp_jax.recordings import stretches

RATE = 250.0
T = 3.0 + np.arange(1000) / RATE


def without(*lost: int) -> np.ndarray:
    return np.delete(T, lost)


def test_uniform_times_are_one_stretch():
    assert stretches(T) == [slice(0, T.size)]


def test_one_lost_sample_is_no_gap():
    assert len(stretches(without(100))) == 1
    assert len(stretches(without(100, 102, 104))) == 1


def test_two_lost_samples_are_one():
    assert stretches(without(100, 101)) == [slice(0, 100), slice(100, 998)]


def test_stretches_hold_every_sample_once_and_no_gap():
    rng = np.random.default_rng(0)
    t = T[rng.random(T.size) > 0.05]
    t = t[(t < 4.0) | (t > 5.0)]
    parts = stretches(t)
    assert len(parts) > 1
    np.testing.assert_array_equal(
        np.concatenate([np.arange(t.size)[p] for p in parts]), range(t.size)
    )
    assert all(np.diff(t[p]).max(initial=0.0) < 2.01 / RATE for p in parts)
    assert all(t[b.start] - t[a.stop - 1] > 2.99 / RATE for a, b in pairwise(parts))


def test_an_island_is_a_stretch():
    parts = stretches(without(*range(100, 110), *range(111, 120)))
    assert parts == [slice(0, 100), slice(100, 101), slice(101, 981)]


@pytest.mark.parametrize(
    "steps",
    [
        1.0 + 0.4 * np.random.default_rng(0).uniform(-1.0, 1.0, 999),  # jitter
        np.resize([1.0, 1.0, 2.0], 999),  # times rounded to less than a step
        np.resize([0.1, 0.1, 0.1, 3.7], 999),  # passed on in packets of four
        np.repeat([1.0, 5.0], [700, 299]),  # two rates
        np.geomspace(1.0, 100.0, 999),  # as an integrator chose them
    ],
    ids=["jitter", "rounded", "packets", "two rates", "growing"],
)
def test_uneven_times_are_one_stretch(steps):
    t = 0.004 * np.cumsum(steps)
    assert len(stretches(t)) == 1
    t[500:] += 100.0
    assert [p.stop for p in stretches(t)] == [500, 999]


@pytest.mark.parametrize("n", [0, 1, 2])
def test_too_few_for_a_gap(n):
    assert stretches(T[:n]) == [slice(0, n)]
