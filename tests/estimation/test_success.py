"""Success of random starts."""

import pytest

from tp_jax.estimation.success import success


def test_wilsons_interval():
    # Newcombe (1998), Stat. Med. 17:857, Table I: 15/148 and 0/20
    found = success([True] * 15 + [False] * 133, [1] * 148)
    assert found.ci95 == pytest.approx((0.0624, 0.1605), abs=5e-5)
    none = success([False] * 20, [5] * 20)
    assert none.ci95 == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert none.expected_evaluations is None
    assert none.probability == 0.0


def test_failures_are_paid_for():
    found = success([True, False, True, False], [10, 100, 20, 70])
    assert found.expected_evaluations == 100.0
    assert found.to_dict()["reached"] == 2
    assert found.to_dict()["of"] == 4
    assert isinstance(found.to_dict()["ci95"], list)
