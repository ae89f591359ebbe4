"""Units of torques and inertias where the column's inertia is not given."""

import pytest

from tp_jax.effects import catalogue
from tp_jax.model.inertia_units import per_inertia, scales
from tp_jax.model.parameters import BASE


def test_they_are_those_of_the_parameters_that_scale_with_it():
    for each in BASE:
        assert scales(each.unit) == each.per_inertia, each.name


@pytest.mark.parametrize("unit", ["N m", "N m/rad", "N m s^2/rad^2", "kg m^2"])
def test_torques_and_inertias_are_per_unit_of_it(unit):
    assert per_inertia(unit) == f"{unit}/B1"


@pytest.mark.parametrize("unit", ["rad", "1", "rad/(N m)"])
def test_others_stay(unit):
    assert per_inertia(unit) == unit


def test_no_effect_has_a_torque_behind_a_line():
    units = [a.unit for effect in catalogue().values() for a in effect.amplitudes]
    assert all(scales(unit) == ("N m" in unit) for unit in units)
