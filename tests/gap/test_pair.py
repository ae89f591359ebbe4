"""Two effects that a third resembles are found together, where the third is the best alone."""

import types

import numpy as np
import pytest

from tests.blocks import whole
from tests.standing_in import standing_in
from tp_jax.gap.directions import Variant
from tp_jax.gap.screen import Scored, Screen, predicted_drop


def screen_of(V: np.ndarray, score: np.ndarray, *limits: tuple[float, float]) -> Screen:
    """A screen of as many effects as there are rows, with one amplitude each."""
    scored = []
    for i in range(score.size):
        rows = slice(i, i + 1)
        bounds = np.array([limits[i] if limits else (-np.inf, np.inf)])
        estimate, drop, unbounded = predicted_drop(bounds, V[rows, rows], score[rows])
        variant = standing_in(Variant, effect=types.SimpleNamespace(id=f"e{i}"))
        scored.append(
            Scored(
                variant,
                drop,
                unbounded,
                estimate,
                V[rows, rows],
                np.zeros((1, 1)),
                np.zeros(0),
                rows,
                bounds,
            )
        )
    return Screen(tuple(scored), V, whole(V[None]), {}, score, np.zeros((0, 0)))


def confounded(n: int = 3, noise: int = 0) -> tuple[np.ndarray, np.ndarray, float]:
    """Information and scores of two effects that are there, and of a third that is like both.

    The directions of the two are correlated by 0.3, the third has 0.8 of their sum's. Also how
    large the sum of squares is that they make.
    """
    rng = np.random.default_rng(0)
    a, c, free = (row for row in np.linalg.qr(rng.standard_normal((200, 3)))[0].T)
    b = 0.3 * a + np.sqrt(1.0 - 0.3**2) * c
    both = (a + b) / np.linalg.norm(a + b)
    third = 0.95 * both + np.sqrt(1.0 - 0.95**2) * free
    others = rng.standard_normal((200, noise)) / np.sqrt(200.0)
    J = np.column_stack([a, b, third, others])
    left = 30.0 * (a + b) + 0.3 * rng.standard_normal(200)
    return J.T @ J, -J.T @ left, float(left @ left)


@pytest.mark.parametrize("noise", [0, 6])
def test_the_true_pair_is_found_where_the_best_single_is_a_third(noise):
    V, score, whole = confounded(noise=noise)
    seen = screen_of(V, score)
    assert seen.best()[0].id == "e2"
    a, b, drop = seen.pair()
    assert {a.id, b.id} == {"e0", "e1"}
    assert drop == pytest.approx(whole, rel=0.05)
    assert drop > seen.best()[0].drop


def test_a_pair_takes_at_least_what_its_better_half_takes():
    rng = np.random.default_rng(1)
    for _ in range(20):
        J, r = rng.standard_normal((50, 5)), rng.standard_normal(50)
        seen = screen_of(J.T @ J, -J.T @ r)
        a, b, drop = seen.pair()
        assert drop >= max(s.drop for s in seen.scored) - 1e-9
        rows = [int(a.id[1:]), int(b.id[1:])]
        left = r - J[:, rows] @ np.linalg.lstsq(J[:, rows], r)[0]
        assert drop == pytest.approx(r @ r - left @ left)


def test_bounds_hold_for_both_together():
    """One of the two could only help by a negative amplitude."""
    V, score, _ = confounded()
    seen = screen_of(V, score, (-np.inf, 0.0), (-np.inf, np.inf), (-np.inf, np.inf))
    a, b, drop = seen.pair()
    rows = [int(a.id[1:]), int(b.id[1:])]
    assert drop <= screen_of(V, score).pair()[2]
    assert sorted(rows) == [1, 2]  # e0 with anything is that alone


def test_an_effect_that_a_bound_stops_alone_is_tried_with_others():
    """Alone it would be negative, beside the other it is positive."""
    V, truth = np.array([[1.0, 0.9], [0.9, 1.0]]), np.array([-40.0, 21.0])
    seen = screen_of(V, -V @ truth, (-np.inf, np.inf), (0.0, np.inf))
    assert seen.scored[1].drop == 0.0
    a, b, drop = seen.pair()
    assert {a.id, b.id} == {"e0", "e1"}
    assert drop == pytest.approx(truth @ V @ truth)


def test_there_is_none_of_one():
    assert screen_of(np.eye(1), np.ones(1)).pair() is None
    assert screen_of(np.eye(2), np.array([1.0, 0.0])).pair() is None
    assert screen_of(np.eye(2), np.ones(2)).pair() is not None


def test_only_the_best_are_tried():
    score = np.array([1.0, 2.0, 3.0, 4.0])
    a, b, drop = screen_of(np.eye(4), score).pair(limit=2)
    assert {a.id, b.id} == {"e3", "e2"}
    assert drop == pytest.approx(25.0)
