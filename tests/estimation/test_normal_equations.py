"""Normal equations: steps, covariances and projections of a small linear problem."""

import numpy as np
import pytest

from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.normal_equations import (
    NormalEquations,
    covariance_of,
    efficient_inverse,
    projected,
    scaled_inverse,
)

U = 5


@pytest.fixture
def rows():
    rng = np.random.default_rng(1)
    return rng.normal(size=(60, U)) * 10.0 ** np.array([-3, -1, 0, 1, 2]), rng.normal(size=60)


@pytest.fixture
def normal(rows):
    A, b = rows
    return NormalEquations(-A.T @ b, A.T @ A, np.zeros(U))


def test_a_step_is_the_least_squares_solution(rows, normal):
    A, b = rows
    wide = np.full(U, np.inf)
    found = normal.step(-wide, wide)
    expected, left, *_ = np.linalg.lstsq(A, b, rcond=None)
    np.testing.assert_allclose(found.du, expected, rtol=1e-8)
    assert found.promise == pytest.approx(b @ b - left[0])


def test_the_covariance_is_the_inverse_whatever_the_units(normal):
    expected = np.linalg.inv(normal.H)
    np.testing.assert_allclose(normal.covariance(), expected, rtol=1e-8)
    unit = 10.0 ** np.array([-9, 0, 4, 8, 9])  # a stiffness beside the square of a noise
    found = covariance_of(normal.H / np.outer(unit, unit))
    np.testing.assert_allclose(found, expected * np.outer(unit, unit), rtol=1e-8)


def test_a_prior_counts_as_one_more_reading(rows, normal):
    A, _ = rows
    with_prior = NormalEquations(normal.g, normal.H, np.array([0.0, 9.0, 0.0, 0.0, 0.0]))
    more = np.vstack([A, 3.0 * np.eye(U)[1]])
    np.testing.assert_allclose(with_prior.information, more.T @ more, rtol=1e-12)


def test_of_two_that_only_their_sum_is_known_of_neither_is_known():
    both = np.array([[1.0, 1.0], [1.0, 1.0]])
    assert np.all(np.sqrt(np.diag(covariance_of(both))) > 1e6)
    # a third that moves with them moves with their sum
    np.testing.assert_allclose(scaled_inverse(both), both / 4.0)


def test_what_the_data_do_not_tell_is_not_known_and_does_not_move():
    H = np.diag([4.0, 0.0])
    found = covariance_of(H)
    assert found[0, 0] == pytest.approx(0.25)
    assert 1e20 < found[1, 1] < np.inf
    for inverse in (scaled_inverse, efficient_inverse):
        np.testing.assert_allclose(inverse(H), np.diag([0.25, 0.0]))


def test_a_part_holds_the_others_and_a_projection_re_optimises_them(rows, normal):
    A, _ = rows
    kept, out = [0, 3], [1, 2, 4]
    np.testing.assert_allclose(normal.part(kept).H, A[:, kept].T @ A[:, kept])
    away = A[:, kept] - A[:, out] @ np.linalg.lstsq(A[:, out], A[:, kept], rcond=None)[0]
    np.testing.assert_allclose(projected(normal.H, kept, out), away.T @ away, rtol=1e-6)
    np.testing.assert_allclose(
        np.linalg.inv(normal.covariance()[np.ix_(kept, kept)]), away.T @ away, rtol=1e-5
    )


def test_windows_sum_to_them():
    rng = np.random.default_rng(2)
    r, X, J = rng.normal(size=(3, 30)), rng.normal(size=(3, 30, 4)), rng.normal(size=(3, 30, U))
    found = eliminate(r, X, J)
    pull, prior = np.arange(U, dtype=float), np.ones(U)
    normal = found.summed(pull, prior)
    np.testing.assert_allclose(normal.g, found.g.sum(axis=0) + pull)
    np.testing.assert_allclose(normal.information, found.H.sum(axis=0) + np.eye(U))
