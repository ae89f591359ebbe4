"""Thresholds are constants: nobody moves them at run time."""

import dataclasses

import pytest

from tp_jax.gap import policy
from tp_jax.gap.policy import POLICY, Policy

EVERY = [
    each
    for each in vars(policy).values()
    if isinstance(each, type) and dataclasses.is_dataclass(each)
]


@pytest.mark.parametrize("kind", EVERY, ids=lambda kind: kind.__name__)
def test_a_policy_is_frozen(kind):
    one = kind()
    for field in dataclasses.fields(kind):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(one, field.name, getattr(one, field.name))


def test_all_of_them_are_in_one_and_every_one_says_what_it_holds():
    parts = {type(getattr(POLICY, f.name)) for f in dataclasses.fields(Policy)}
    assert parts == set(EVERY) - {Policy}
    assert POLICY == Policy()
    for kind in parts:
        for field in dataclasses.fields(kind):
            assert field.name in (kind.__doc__ or "")


@pytest.mark.parametrize("kind", sorted(set(EVERY) - {Policy}, key=lambda kind: kind.__name__))
def test_thresholds_are_numbers_above_zero(kind):
    for field in dataclasses.fields(kind):
        value = getattr(kind(), field.name)
        assert isinstance(value, int | float)
        assert value > 0.0
