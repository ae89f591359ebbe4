"""Local polynomials: exact where they can be, with errors that are true."""

import numpy as np
import pytest

from tp_jax.recordings import local_polynomial


@pytest.mark.parametrize("order", [3, 4])
@pytest.mark.parametrize("window", [7, 10, 15])
def test_exact_on_a_cubic(order, window):
    t = 3.0 + np.cumsum(np.random.default_rng(0).uniform(0.003, 0.005, 200))
    p = np.polynomial.Polynomial([50.0, -2.0, 3.0, 7.0])
    smoothed = local_polynomial(t, p(t), 1e-3, window, order)
    np.testing.assert_allclose(smoothed.value, p(t), rtol=1e-12)
    np.testing.assert_allclose(smoothed.first, p.deriv()(t), rtol=1e-7)
    np.testing.assert_allclose(smoothed.second, p.deriv(2)(t), rtol=1e-4)


def test_window_and_order_may_be_the_least():
    t = np.arange(3.0)
    smoothed = local_polynomial(t, t**2, 0.1, 15, order=2)  # the window is cut to three samples
    np.testing.assert_allclose(smoothed.first, 2.0 * t, atol=1e-12)
    np.testing.assert_allclose(smoothed.value_error, 0.1)  # an interpolation


def test_errors_are_those_of_many_repetitions():
    t = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 40))
    random = np.random.default_rng(1)
    all_ = [local_polynomial(t, random.standard_normal(t.size), 1.0, 11) for _ in range(2000)]
    for name in ("value", "first", "second"):
        scatter = np.std([getattr(each, name) for each in all_], axis=0)
        np.testing.assert_allclose(getattr(all_[0], f"{name}_error"), scatter, rtol=0.1)


@pytest.mark.parametrize(("period", "grown"), [(9, 50.0), (12, 20.0), (300, 1.0)])
def test_errors_count_what_the_polynomial_cannot_follow(period, grown):
    """A motion of nine samples a period is missed by fifty times the noise or more."""
    t = np.arange(600.0)
    angle = 2.0 * np.pi * t / period
    y = np.sin(angle) + 1e-4 * np.random.default_rng(0).standard_normal(t.size)
    smoothed = local_polynomial(t, y, 1e-4, 7)
    middle = slice(3, -3)
    wrong = (smoothed.value - np.sin(angle))[middle] / smoothed.value_error[middle]
    assert np.sqrt(np.mean(wrong**2)) < 1.5
    steady = local_polynomial(t, 0.0 * t, 1e-4, 7).value_error
    assert np.median(smoothed.value_error / steady) > 0.99 * grown


def test_without_noise_errors_are_what_the_polynomial_leaves():
    t = np.arange(60.0)
    smoothed = local_polynomial(t, np.sin(0.6 * t), 0.0, 7)
    assert np.isfinite(smoothed.value_error).all()
    assert smoothed.value_error.max() > 0.0


def test_errors_grow_at_the_ends():
    t = 0.004 * np.arange(300)
    error = local_polynomial(t, np.sin(t), 1e-3, 15).first_error
    assert error[0] > 3.0 * error[150]
    assert error[-1] == pytest.approx(error[0])


def test_a_gap_is_an_end():
    t = 0.004 * np.arange(300)
    y = np.sin(13.0 * t) + (t > 0.5) * np.pi  # a branch lost in the gap
    left, right = t < 0.4, t > 0.8
    kept = left | right
    both = local_polynomial(t[kept], y[kept], 1e-3, 15)
    alone = [local_polynomial(t[part], y[part], 1e-3, 15) for part in (left, right)]
    for together, apart in zip(both, zip(*alone, strict=True), strict=True):
        np.testing.assert_array_equal(together, np.concatenate(apart))


def test_too_few_samples_between_two_gaps():
    t = 0.004 * np.concatenate([np.arange(100), [200, 201, 202], np.arange(300, 400)])
    smoothed = local_polynomial(t, np.sin(t), 1e-3, 15)
    island = slice(100, 103)
    np.testing.assert_array_equal(smoothed.value[island], np.sin(t[island]))
    np.testing.assert_array_equal(smoothed.value_error[island], 1e-3)
    for name in ("first", "second"):
        np.testing.assert_array_equal(getattr(smoothed, name)[island], 0.0)
        np.testing.assert_array_equal(getattr(smoothed, f"{name}_error")[island], np.inf)
    assert np.isfinite(smoothed.first_error[:100]).all()


@pytest.mark.parametrize(("n", "window", "order"), [(100, 3, 3), (100, 15, 1), (2, 15, 2)])
def test_too_few_samples_for_the_order(n, window, order):
    with pytest.raises(ValueError, match="more samples than its order"):
        local_polynomial(np.arange(float(n)), np.zeros(n), 1.0, window, order)
