"""Weights of hypotheses from what they leave of groups, in plain numbers."""

import numpy as np
import pytest

from tp_jax.gap.policy import FoldPolicy
from tp_jax.gap.probability import Densities, weights

POLICY = FoldPolicy()


def of(log: list, apart: list | None = None) -> np.ndarray:
    """Weights where predictions are as far apart as log densities say, or as is said."""
    log = np.array(log, float)
    if apart is None:
        distance = 2.0 * np.abs(log[:, None] - log[None, :])
    else:
        distance = np.abs(np.array(apart, float)[:, None] - np.array(apart, float)[None, :])
    return weights(Densities(log, distance, np.zeros(len(log))), POLICY)


def test_one_that_every_group_speaks_for_is_certain():
    assert of([np.zeros(5), np.full(5, 30.0)])[1] > 0.99


def test_effects_that_predict_alike_share_what_there_is():
    nothing, a, b = of([np.zeros(5), np.full(5, 30.0), np.full(5, 30.0)])
    assert a == pytest.approx(b) == pytest.approx(0.5, abs=0.01)
    assert nothing < 0.01


def test_groups_that_disagree_leave_it_open():
    """However many samples they have: the sum alone would be certain of the second."""
    groups = np.array([90.0, -40.0, 70.0, -50.0, -30.0])
    assert groups.sum() > 30.0
    assert 0.2 < of([np.zeros(5), groups], [np.zeros(5), np.full(5, 100.0)])[1] < 0.9


def test_groups_that_tell_different_amounts_agree():
    """A decay may tell a hundred times what a run at another frequency does."""
    assert of([np.zeros(8), [1.0, 0.0, 2.0, 3.0, 12.0, 1.0, 30.0, 25.0]])[1] > 0.99


def test_one_group_cannot_decide_alone():
    assert of([np.zeros(5), np.array([60.0, -1.0, -1.0, -1.0, -1.0])])[1] < 0.95


def test_too_few_groups_leave_what_was_known_before():
    prior = np.log([0.5, 0.25, 0.25])
    log = np.array([np.zeros(2), np.full(2, 1e4), np.zeros(2)])
    found = weights(Densities(log, np.zeros((3, 3, 2)), np.zeros(3), prior), POLICY)
    assert found == pytest.approx([0.5, 0.25, 0.25])


def test_what_tells_nothing_leaves_what_was_known_before():
    """However much the groups scatter: the prior is not tempered with them."""
    prior = np.log([0.5, 0.25, 0.25])
    found = weights(Densities(np.zeros((3, 5)), np.zeros((3, 3, 5)), np.zeros(3), prior), POLICY)
    assert found == pytest.approx([0.5, 0.25, 0.25])


def test_one_that_was_not_refitted_is_known_no_better_than_the_others():
    log = np.array([np.zeros(5), np.full(5, 30.0), np.full(5, 29.0)])
    apart = np.full((3, 3, 5), np.nan)
    apart[:2, :2] = 2.0 * np.abs(log[:2, None] - log[None, :2])
    nothing, a, b = weights(Densities(log, apart, np.zeros(len(log))), POLICY)
    assert a > b > nothing


@pytest.mark.parametrize("noise", [1.0, 2.0])
def test_stated_probabilities_are_kept_where_recordings_have_errors_in_common(noise):
    """Two models d apart, the data about one of them, with an error by group beside the noise."""
    rng = np.random.default_rng(0)
    stated, right = [], []
    for _ in range(600):
        d = rng.uniform(0.5, 2.0, 6)  # sqrt of the distance in each group
        true = rng.integers(2)
        # along the line between the two models, which lie at 0 and d
        y = true * d + noise * rng.standard_normal(6)
        log = np.array([-0.5 * y**2, -0.5 * (y - d) ** 2])
        apart = np.zeros((2, 2, 6))
        apart[0, 1] = apart[1, 0] = d**2
        p = weights(Densities(log, apart, np.zeros(len(log))), POLICY)
        stated.append(p.max())
        right.append(p.argmax() == true)
    stated, right = np.array(stated), np.array(right)
    for low, high in ((0.5, 0.75), (0.75, 0.9), (0.9, 1.0)):
        inside = (stated >= low) & (stated < high)
        if inside.sum() > 50:
            assert -0.1 < right[inside].mean() - stated[inside].mean() < 0.15
