"""In how many recordings a cause improves the fit, of errors made up."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import agreement as module
from tp_jax.gap.agreement import agreement
from tp_jax.gap.choice import Choice
from tp_jax.gap.held_out import HeldOut

SETTING = standing_in(
    PreparedCampaign,
    recordings=[Some(label=label) for label in ("first", "second", "third", "held")],
)


def fit(left_out, recording=(0, 0, 1, 2)):
    """With a sum of squares in each window when it is left out."""
    windows = Some(recording=np.array(recording))
    return standing_in(Fit, problem=Some(windows=windows), left_out=np.array(left_out, float))


def held(squares, complete=True):
    """Of one recording, number 3, in windows of one sample."""
    r = np.sqrt(np.array(squares, float))[:, None]
    rows = np.concatenate([r, np.ones((r.size, 4))], axis=1)  # and the prior's, which do not count
    windows = Some(recording=np.full(r.size, 3))
    fit = standing_in(Fit, problem=Some(windows=windows), linearisation=Some(r=rows))
    return standing_in(HeldOut, complete=complete, fit=fit)


@pytest.fixture(autouse=True)
def as_given(monkeypatch):
    monkeypatch.setattr(module, "left_out_cost", lambda fit: fit.left_out)


def choice(without, with_it):
    refits = {"spin": Some(fit=fit(with_it))}
    return standing_in(Choice, rounds=[Some(searched=fit(without), refits=refits)])


def test_recordings_are_counted_by_what_each_of_them_says():
    found = agreement(
        "spin", SETTING, choice([20, 20, 30, 10], [15, 15, 27, 19]), held([9, 9]), held([4, 1])
    )
    assert found is not None
    assert found.drops == pytest.approx({"first": 10.0, "second": 3.0, "third": -9.0, "held": 13.0})
    assert (found.improved, found.of) == (2, 4)  # 3 is no more than noise
    assert found.worse == ("third",)


def test_held_out_ones_count_only_where_both_models_can_be_followed():
    both = choice([20, 20, 30, 10], [15, 15, 20, 2])
    for after in (None, held([1], complete=False)):
        found = agreement("spin", SETTING, both, held([9]), after)
        assert found is not None
        assert (found.improved, found.of) == (3, 3)


def test_nothing_is_said_of_what_was_not_refitted():
    assert agreement("drag", SETTING, choice([1] * 4, [1] * 4), held([1]), None) is None
