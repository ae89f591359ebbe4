"""Recordings of one rig have its parameters, each alone."""

import pytest

from tests.reference import BENCH
from tp_jax.validation import consistency


@pytest.fixture(scope="module")
def alike(right):
    setting, fit = right
    return consistency(fit, setting)


def test_of_one_rig(alike):
    assert alike.recordings == ("decay.csv", "run-13.csv", "run-17.csv")
    assert not alike.rejected
    assert alike.degrees > 0
    assert alike.differing == ()


def test_values_alone(alike):
    for label in alike.recordings:
        assert alike.values["k"][label] == pytest.approx(BENCH["k"], rel=0.02)
    # a decay has no drive
    assert alike.values["A"]["decay.csv"] is None
    assert alike.values["A"]["run-13.csv"] == pytest.approx(BENCH["A"], rel=0.05)


def test_of_two_rigs(wrong):
    setting, fit = wrong
    found = consistency(fit, setting)
    assert found.rejected
    assert found.p < 1e-6
    assert found.to_dict()["rejected"]
