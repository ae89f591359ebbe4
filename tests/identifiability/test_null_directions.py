"""Null spaces come back in few parameters and whole coefficients."""

import numpy as np
import pytest

from tp_jax.identifiability.null_directions import Direction, sparse_basis

NAMES = ("a", "b", "c", "d", "e")


def mixed(*rows, seed=0):
    """An orthonormal basis of the rows' span that shows nothing of them."""
    rows = np.array(rows, float)
    turned = np.random.default_rng(seed).normal(size=(len(rows),) * 2) @ rows
    return np.linalg.qr(turned.T)[0].T


def same(found, expected):
    def key(c):
        return sorted((n, round(x, 6)) for n, x in c.items())

    return sorted(map(key, found)) == sorted(map(key, expected))


@pytest.mark.parametrize("seed", range(5))
def test_a_common_factor_and_one_alone(seed):
    found = sparse_basis(mixed([1, 1, 1, 0, 0], [0, 0, 0, 0, 1], seed=seed), NAMES)
    assert same(found, [{"a": 1.0, "b": 1.0, "c": 1.0}, {"e": 1.0}])


@pytest.mark.parametrize("seed", range(5))
def test_two_that_share_a_parameter(seed):
    rows = ([1, 1, 0, 0, 1], [0, 0, 1, 1, -1])
    found = sparse_basis(mixed(*rows, seed=seed), NAMES)
    assert len(found) == 2
    # whatever the two are, they span the same space
    table = np.array([[c.get(n, 0.0) for n in NAMES] for c in found])
    assert np.linalg.matrix_rank(np.concatenate([table, np.array(rows)])) == 2
    assert all(max(np.abs(list(c.values()))) == pytest.approx(1.0) for c in found)


def test_no_null_space():
    assert sparse_basis(np.zeros((0, 5)), NAMES) == []


def test_everything_is_null():
    found = sparse_basis(mixed(*np.eye(5).tolist()), NAMES)
    assert same(found, [{n: 1.0} for n in NAMES])


def test_in_words():
    assert "no effect" in Direction({"a": 1.0}, "structural").text
    assert Direction({"a": 1.0, "b": 1.0}, "structural").text == "a and b: all by one factor"
    assert "-0.5" in Direction({"a": 1.0, "b": -0.5}, "practical", 2.0).text
    assert Direction({"a": 1.0}, "structural").to_dict()["sd_log"] is None
