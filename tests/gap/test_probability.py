"""Weights of hypotheses from what they predict of groups left out, in plain numbers."""

import numpy as np
import pytest

from tp_jax.gap.policy import FoldPolicy
from tp_jax.gap.probability import _weights

POLICY = FoldPolicy()


def test_one_that_every_group_speaks_for_is_certain():
    table = np.array([np.zeros(5), np.full(5, 30.0)])
    assert _weights(table, 0, POLICY)[1] > 0.99


def test_effects_that_predict_alike_share_what_there_is():
    table = np.array([np.zeros(5), np.full(5, 30.0), np.full(5, 30.0)])
    nothing, a, b = _weights(table, 0, POLICY)
    assert a == pytest.approx(b) == pytest.approx(0.5, abs=0.01)
    assert nothing < 0.01


def test_groups_that_disagree_leave_it_open():
    """However many samples they have: the sum alone would be certain of the second."""
    table = np.array([np.zeros(5), np.array([90.0, -40.0, 70.0, -50.0, -30.0])])
    assert table[1].sum() > 30.0
    assert 0.2 < _weights(table, 0, POLICY)[1] < 0.9


def test_one_group_cannot_decide_alone():
    """What a single recording says is not there in a draw without it."""
    table = np.array([np.zeros(5), np.array([60.0, -1.0, -1.0, -1.0, -1.0])])
    assert _weights(table, 0, POLICY)[1] < 0.95


def test_too_few_groups_give_a_flat_answer():
    table = np.array([np.zeros(2), np.full(2, 1e4), np.zeros(2)])
    assert _weights(table, 0, POLICY) == pytest.approx(np.full(3, 1 / 3))


def test_the_bootstrap_has_the_groups_own_variance():
    """Of a sum over few groups: with the mean taken off, it is G s^2."""
    rng = np.random.default_rng(1)
    x = rng.standard_normal(6)
    draws = rng.dirichlet(np.full(6, (6 - 2.0) / 6), 200_000) * 6 @ x
    assert draws.var() == pytest.approx(6 * x.var(ddof=1), rel=0.02)
