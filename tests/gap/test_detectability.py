"""Detectable sizes and ties from information matrices."""

import numpy as np
import pytest
from scipy import stats

from tests.standing_in import standing_in
from tp_jax.estimation.normal_equations import efficient_inverse
from tp_jax.gap.detectability import (
    middle_detectable,
    minimum_detectable,
    needed_noncentrality,
)
from tp_jax.gap.screen import Scored


def seen(V, lower=-np.inf, upper=np.inf):
    return standing_in(Scored, V=np.asarray(V), limits=np.array([(lower, upper)] * len(V)))


def test_noncentrality_of_one_amplitude_is_that_of_a_normal():
    alpha = 0.05 / 20
    z = stats.norm.isf(alpha / 2) + stats.norm.isf(0.05)
    assert needed_noncentrality(1, 20) == pytest.approx(z**2, rel=1e-3)


def test_power_by_simulation():
    V, tests = np.array([[4.0]]), 10
    size = minimum_detectable(seen(V), tests, 1.0)
    rng = np.random.default_rng(0)
    estimate = size + rng.normal(size=20_000) / np.sqrt(V[0, 0])
    found = stats.chi2.sf(estimate**2 * V[0, 0], 1) < 0.05 / tests
    assert found.mean() == pytest.approx(0.95, abs=0.01)


def test_least_detectable_direction_and_physical_range():
    V = np.diag([100.0, 1.0])
    one = minimum_detectable(seen(V), 10, 1.0)
    assert one == pytest.approx(np.sqrt(needed_noncentrality(2, 10)))
    assert minimum_detectable(seen(V, -1.0, 1.0), 10, 1.0) is None
    assert minimum_detectable(seen(np.zeros((1, 1))), 10, 1.0) is None


def test_of_shapes_nobody_knows_the_middle_size_counts():
    """At the frequency that noise fits best a vibration may show far better than at its own."""
    at = [seen([[v]]) for v in (1.0, 100.0, 1e4)]
    sizes = [minimum_detectable(s, 10, 1.0) for s in at]
    assert middle_detectable(at, 10, 1.0) == sizes[1]
    hidden = seen([[0.0]])
    assert middle_detectable([*at[1:], hidden], 10, 1.0) == sizes[1]
    assert middle_detectable([*at[1:], hidden, hidden], 10, 1.0) is None
    assert middle_detectable(at[:2], 10, 1.0) == sizes[0]


def test_pseudo_inverse_ignores_scales():
    rng = np.random.default_rng(3)
    A = rng.normal(size=(6, 4))
    V = A.T @ A
    D = np.diag([1.0, 1e3, 1e-3, 1.0])
    assert efficient_inverse(D @ V @ D) == pytest.approx(
        np.linalg.inv(D) @ np.linalg.inv(V) @ np.linalg.inv(D), rel=1e-5
    )
