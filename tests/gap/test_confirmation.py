"""When a cause improves the prediction of what was left out: plain numbers."""

import numpy as np
import pytest

from tp_jax.gap.confirmation import confirm
from tp_jax.gap.left_out import LeftOut
from tp_jax.gap.policy import ConfirmPolicy

POLICY = ConfirmPolicy()
SHORT, LONG = (100.0, 100.0, 100.0, 100.0), (4.0, 4.0, 4.0, 4.0)


def errors(short=SHORT, long=LONG) -> LeftOut:
    return LeftOut(np.array(short), np.zeros((len(short), 1)), lambda: np.array(long))


def judged(short, long=LONG, misfit=1.0, amplitudes=1, before=SHORT, before_long=LONG):
    return confirm(errors(before, before_long), errors(short, long), misfit, amplitudes, POLICY)


def test_a_cause_that_every_group_speaks_for():
    found = judged((90.0, 90.0, 90.0, 90.0), (1.0, 1.0, 1.0, 1.0))
    assert found.confirmed
    assert found.reason == ""
    assert found.deviance == 40.0
    assert found.lost == 0.0
    assert found.error_ratio == pytest.approx(0.5)


def test_the_fall_has_to_be_above_what_a_search_finds_by_chance():
    needed = POLICY.deviance + POLICY.per_amplitude
    at, above = (100.0 - needed, *SHORT[1:]), (100.0 - needed - 0.1, *SHORT[1:])
    assert not judged(at).confirmed
    assert "beyond chance" in judged(at).reason
    assert judged(above).confirmed
    assert not judged(above, amplitudes=2).confirmed  # more of them find more by chance


def test_a_wrong_model_is_not_certain_of_details():
    short = (90.0, 90.0, 90.0, 90.0)
    assert judged(short).confirmed
    assert judged(short, misfit=4.0).deviance == 10.0
    assert not judged(short, misfit=4.0).confirmed
    assert judged(short, misfit=0.25) == judged(short)  # nor is one that fits too well more so


def test_what_some_gain_others_must_not_lose():
    found = judged((20.0, 100.0, 100.0, 121.0))
    assert found.deviance == 59.0
    assert found.lost == pytest.approx(21.0 / 80.0)
    assert not found.confirmed
    assert "others worse" in found.reason
    assert judged((20.0, 100.0, 100.0, 119.0)).confirmed


def test_long_runs_are_not_asked_where_the_short_ones_refuse():
    """They take most of the time."""

    def asked():
        raise AssertionError("long windows were fitted")

    before, after = (LeftOut(np.array(SHORT), np.zeros((4, 1)), asked) for _ in range(2))
    found = confirm(before, after, 1.0, 1, POLICY)
    assert not found.confirmed
    assert np.isnan(found.error_ratio)


def test_long_runs_must_not_get_worse():
    better = (50.0, 50.0, 50.0, 50.0)
    assert judged(better, tuple(4.0 * 1.03**2 for _ in LONG)).error_ratio == pytest.approx(1.03)
    assert "long runs" in judged(better, tuple(4.0 * 1.03**2 for _ in LONG)).reason
    assert judged(better, tuple(4.0 * 1.01**2 for _ in LONG)).confirmed


def test_long_runs_that_cannot_be_integrated():
    """Count against the cause that cannot, and say nothing where the other model could not."""
    better = (50.0, 50.0, 50.0, 50.0)
    lost = (4.0, np.nan, 4.0, 4.0)
    assert judged(better, lost).error_ratio == np.inf
    assert not judged(better, lost).confirmed
    assert judged(better, before_long=lost).error_ratio == pytest.approx(1.0)
    assert judged(better, before_long=lost).confirmed
    assert judged(better, (np.nan,) * 4, before_long=(np.nan,) * 4).error_ratio == 1.0


def test_a_group_that_a_model_cannot_follow():
    with_one = (50.0, np.inf, 50.0, 50.0)
    assert not judged(with_one).confirmed
    assert judged(with_one).deviance == -np.inf
    assert judged((50.0, 50.0, 50.0, 50.0), before=(100.0, np.inf, 100.0, 100.0)).confirmed


def test_no_gain_at_all():
    found = judged(SHORT)
    assert not found.confirmed
    assert found.deviance == 0.0
    assert found.lost == np.inf
