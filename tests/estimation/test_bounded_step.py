"""A step within bounds is the minimum of the model there."""

import numpy as np
import pytest
from scipy.optimize import minimize

from tp_jax.estimation.bounded_step import bounded_step


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("damping", [0.0, 1e-2, 10.0])
def test_minimum_within_bounds(seed, damping):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(8, 5)) * 10.0 ** rng.uniform(-2, 2, 5)
    H, g = J.T @ J, J.T @ rng.normal(size=8)
    size = np.abs(np.linalg.solve(H, g))
    lower, upper = -size * rng.uniform(0.1, 2.0, 5), size * rng.uniform(0.1, 2.0, 5)
    step = bounded_step(g, H, lower, upper, damping)
    assert (step.du >= lower).all()
    assert (step.du <= upper).all()
    D = H + damping * np.diag(np.diag(H))
    scale = np.sqrt(np.diag(H))
    found = minimize(
        lambda z: 2.0 * (g / scale) @ z + z @ (D / np.outer(scale, scale)) @ z,
        np.zeros(5),
        bounds=list(zip(lower * scale, upper * scale, strict=True)),
        options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 10_000},
    )
    np.testing.assert_allclose(step.du * scale, found.x, rtol=1e-3, atol=1e-5)
    promise = -(2.0 * g @ step.du + step.du @ H @ step.du)
    assert step.promise == pytest.approx(promise)
    assert step.promise > 0.0


def test_what_is_not_told_does_not_move():
    H = np.diag([4.0, 0.0])
    step = bounded_step(np.array([2.0, 0.0]), H, np.full(2, -1.0), np.full(2, 1.0), 0.0)
    np.testing.assert_allclose(step.du, [-0.5, 0.0], atol=1e-12)


def test_an_unknown_with_no_room_stays():
    H = np.eye(2)
    step = bounded_step(np.array([1.0, 1.0]), H, np.array([0.0, -9.0]), np.array([0.0, 9.0]), 0.0)
    np.testing.assert_allclose(step.du, [0.0, -1.0], atol=1e-9)
