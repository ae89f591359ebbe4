"""Least squares with noisy regressors."""

import numpy as np
import pytest

from tp_jax.estimation.compensated import Rows


def rows(noise, n=4000, seed=0):
    """b = 2 a - 3 c, with noise on a; and what is known of it."""
    rng = np.random.default_rng(seed)
    clean = rng.normal(size=(n, 2))
    A = clean + noise * rng.normal(size=(n, 2)) * [1.0, 0.0]
    covariance = np.zeros((n, 2, 3))
    covariance[:, 0, 0] = noise**2
    return Rows(("a", "c"), A, clean @ [2.0, -3.0], covariance, np.arange(n) // 100)


def test_noise_is_taken_off():
    data = rows(1.0)
    plain = Rows(data.names, data.A, data.b, 0.0 * data.noise, data.block)
    times = np.ones(40)
    assert plain.solve(times, {}, frozenset(), {})["a"] == pytest.approx(1.0, rel=0.1)
    found = data.solve(times, {}, frozenset(), {})
    assert found["a"] == pytest.approx(2.0, rel=0.1)
    assert found["c"] == pytest.approx(-3.0, rel=0.05)


def test_known_and_positive():
    data, times = rows(0.0), np.ones(40)
    assert data.solve(times, {"a": 2.5}, frozenset(), {})["a"] == 2.5
    assert data.solve(times, {"a": 2.0, "c": -3.0}, frozenset(), {}) == {"a": 2.0, "c": -3.0}
    found = data.solve(times, {}, frozenset({"c"}), {})
    assert found["c"] == 0.0
    assert data.misfit(times, {"a": 2.0, "c": -3.0}) == pytest.approx(0.0, abs=1e-20)


def test_a_prior_decides_only_what_the_rows_do_not_tell():
    data, times = rows(0.0), np.ones(40)
    prior = {"a": (7.0, 1.0)}
    assert data.solve(times, {}, frozenset(), prior)["a"] == pytest.approx(2.0, rel=1e-3)
    blind = Rows(data.names, data.A * [0.0, 1.0], -3.0 * data.A[:, 1], data.noise, data.block)
    assert blind.solve(times, {}, frozenset(), prior)["a"] == pytest.approx(7.0, rel=1e-6)


def test_blocks_count_as_often_as_they_are_drawn():
    data = rows(0.0)
    b = np.where(data.block == 3, data.A @ [5.0, 1.0], data.b)
    times = np.zeros(40)
    times[3] = 2.0
    odd = Rows(data.names, data.A, b, data.noise, data.block)
    assert odd.solve(times, {}, frozenset(), {}) == pytest.approx({"a": 5.0, "c": 1.0})
