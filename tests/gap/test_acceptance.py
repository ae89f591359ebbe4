"""Which chosen effects are named: likely ones, whose size is not zero."""

from types import SimpleNamespace

import pytest

from tests.standing_in import standing_in
from tp_jax.effects import catalogue
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import acceptance
from tp_jax.gap.acceptance import has_size, is_worse, least_probable, with_ties
from tp_jax.gap.choice import Choice
from tp_jax.gap.refit import Refit
from tp_jax.results.diagnosis import Errors

SETTING = standing_in(PreparedCampaign)


def result(*ids):
    variants = tuple(SimpleNamespace(effect=catalogue()[id]) for id in ids)
    return standing_in(Refit, variants=variants, fit=None, ids=ids)


@pytest.fixture
def sizes(monkeypatch):
    """Sets the intervals of amplitudes."""

    def put(**intervals):
        every = {name.replace("__", "."): {"ci95": ci} for name, ci in intervals.items()}
        monkeypatch.setattr(acceptance, "intervals", lambda fit, setting: every)

    return put


@pytest.mark.parametrize(
    ("interval", "there"),
    [
        ((0.1, 0.3), True),
        ((-0.3, -0.1), True),
        ((-0.1, 0.3), False),
        ((0.0, 0.3), False),  # at the bound of what may not be negative
        ((0.0, None), False),
    ],
)
def test_a_size_is_an_interval_without_zero(sizes, interval, there):
    sizes(bearing_drag__a=interval)
    assert has_size(SETTING, result("bearing_drag"), "bearing_drag") == there


def test_of_two_amplitudes_one_is_enough(sizes):
    sizes(column_tilt__a=(-0.1, 0.1), column_tilt__b=(0.2, 0.3))
    assert has_size(SETTING, result("column_tilt"), "column_tilt")


def test_amplitudes_of_recordings_have_no_size_of_the_campaign(sizes):
    sizes()
    assert has_size(SETTING, result("contact_repeatability"), "contact_repeatability")


def test_ties_count_together(monkeypatch):
    groups = [["column_tilt", "spring_asymmetry"], ["column_tilt", "clock_skew", "bearing_drag"]]
    monkeypatch.setattr(acceptance, "tied", lambda setting, choice: groups)
    p = {"column_tilt": 0.4, "spring_asymmetry": 0.3, "clock_skew": 0.2, "bearing_drag": 0.05}
    choice = standing_in(Choice, causes=("column_tilt",))
    # a group counts as one, with three members at most
    assert with_ties(SETTING, choice, "column_tilt", p) == pytest.approx(0.9)
    assert with_ties(SETTING, choice, "spring_asymmetry", p) == pytest.approx(0.7)
    assert least_probable(SETTING, choice, p) == pytest.approx(0.9)
    assert least_probable(SETTING, standing_in(Choice, causes=()), p) == 1.0


def test_worse_is_worse_in_windows_or_in_a_free_run():
    before = Errors(1.0, 2.0)
    assert not is_worse(before, Errors(1.01, 2.0))
    assert is_worse(before, Errors(1.1, 1.0))
    assert is_worse(before, Errors(0.5, 2.1))
    assert is_worse(before, Errors(0.5, None))
    assert not is_worse(Errors(1.0, None), Errors(0.9, 9.0))
