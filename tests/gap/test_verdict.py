"""The verdict, by what it rests on."""

import dataclasses

import pytest

from tp_jax.gap.held_out import Shrink
from tp_jax.gap.policy import POLICY, VerdictPolicy
from tp_jax.gap.verdict import Evidence, combined, verdict

GONE, PARTLY, NONE = (
    Shrink(0.9999, (0.9995, 1.0), True),
    Shrink(0.9, (0.8, 0.95), True),
    Shrink(None, None, False),
)

#: A large gap of which one sure cause leaves noise alone.
PLAIN = Evidence(
    structure_p=0.001,
    structure_p_after=0.4,
    causes=1,
    probability=0.99,
    shrink=GONE,
    rest=0.01,
    rest_error=0.03,
    gap_rms=5e-3,
    rest_rms=1e-4,
)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({}, "explained"),
        ({"structure_p": 0.4, "causes": 0}, "no_gap"),
        ({"structure_p": 0.4}, "no_gap"),
        # what the tests see is a gap, however small the error on held-out data
        ({"gap_rms": 0.0, "causes": 0}, "unknown"),
        ({"gap_rms": 0.0}, "explained"),
        ({"causes": 0}, "unknown"),
        ({"probability": 0.8}, "unknown"),
        ({"worse": True}, "unknown"),
        # a small gap counts, though the noise hides its share on held-out data
        ({"shrink": NONE}, "explained"),
        ({"shrink": PARTLY}, "explained"),
        # the gap on held-out data is seen, and no smaller than before
        ({"shrink": Shrink(-0.1, (-0.9, 0.7), True)}, "unknown"),
        # structure is left: of a large gap next to nothing may be
        ({"structure_p_after": 0.001}, "explained"),
        ({"structure_p_after": 0.001, "shrink": PARTLY}, "unknown"),
        # what is left is above the noise, whatever part of the gap is gone
        ({"rest": 0.5}, "unknown"),
        ({"rest": 37.0, "structure_p_after": 0.001}, "unknown"),
        ({"rest": 0.08, "structure_p_after": 0.001}, "explained"),
    ],
)
def test_word(changes, word):
    assert verdict(dataclasses.replace(PLAIN, **changes)) == word


def test_tolerance_says_which_gap_matters():
    left = dataclasses.replace(PLAIN, rest=37.0, structure_p_after=0.001, rest_rms=2e-3)
    assert verdict(left) == "unknown"
    assert verdict(left, tolerance=2.5e-3) == "explained"
    assert verdict(left, tolerance=6e-3) == "no_gap"
    assert verdict(dataclasses.replace(left, probability=0.5), tolerance=2.5e-3) == "unknown"


def test_policy_decides():
    strict = dataclasses.replace(POLICY, verdict=VerdictPolicy(probability=0.995))
    assert verdict(PLAIN, policy=strict) == "unknown"


def test_any_test_of_structure_is_enough():
    assert combined(0.194, 0.291, 0.0) == pytest.approx(0.4)
    assert combined(0.00097, 1.0, 0.0) == pytest.approx(0.002)
    assert combined(1.0, 0.00097, 0.0) == pytest.approx(0.002)
    assert combined(1.0, 0.7, -1.0) == 1.0
    # a misfit beyond the noise that no effect sees
    assert combined(1.0, 1.0, 3.6) < POLICY.structure.level < combined(1.0, 1.0, 2.9)


def test_the_parts_of_the_level_are_the_whole():
    s = POLICY.structure
    assert s.catalogue + s.free + s.misfit == pytest.approx(1.0)


@pytest.mark.parametrize("p", [0.0, 0.0249, 0.025, 0.049, 0.05, 0.4, 1.0])
@pytest.mark.parametrize("gap_rms", [0.0, 1e-3, float("inf")])
@pytest.mark.parametrize("causes", [0, 1, 3])
def test_without_a_tolerance_no_gap_is_what_the_tests_say(p, gap_rms, causes):
    evidence = dataclasses.replace(PLAIN, structure_p=p, gap_rms=gap_rms, causes=causes)
    assert (verdict(evidence) == "no_gap") == (p >= POLICY.structure.alarm)
