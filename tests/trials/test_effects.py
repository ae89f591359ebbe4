"""Effects beyond the package's catalogue keep what every effect has to keep."""

import pytest

from tests.rig.any_effect import any_two_effects_on_any_rig, demands
from tp_jax.effects import CHANNELS
from tp_jax.rig.effects import catalogue
from trials.effects.base import Outside

BEYOND = [id for id, effect in catalogue().items() if isinstance(effect, Outside)]


def test_they_act_through_every_channel():
    assert len(BEYOND) >= 8
    assert {catalogue()[id].channel for id in BEYOND} == set(CHANNELS.values())
    assert not any(catalogue()[id].in_catalogue for id in BEYOND)


@pytest.mark.parametrize(("demand", "id"), demands(BEYOND))
def test_every_effect(demand, id):
    demand(id)


@pytest.mark.parametrize("seed", range(12))
def test_any_two_effects_on_any_rig(seed):
    any_two_effects_on_any_rig(catalogue(), seed)
