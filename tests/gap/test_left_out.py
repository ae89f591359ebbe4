"""Which windows are left out together."""

import types

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.left_out import groups
from tp_jax.gap.policy import FoldPolicy

POLICY = FoldPolicy()
PERIOD, WINDOW = 0.5, 0.25  # s


def grouped(*durations: float, recordings=None, within: bool = False, policy=POLICY):
    """Windows of a quarter of a second of recordings that last so long, and their groups."""
    recordings = range(len(durations)) if recordings is None else recordings
    prepared = [types.SimpleNamespace(t=np.linspace(0.0, d, 100)) for d in durations]
    which = np.concatenate([np.full(max(1, round(durations[r] / WINDOW)), r) for r in recordings])
    setting = standing_in(PreparedCampaign, prepared=prepared, period=PERIOD)
    windows = types.SimpleNamespace(recording=which, n=which.size)
    fit = standing_in(Fit, problem=types.SimpleNamespace(windows=windows))
    return which, groups(setting, fit, policy, within=within)


def contiguous(group: np.ndarray) -> bool:
    return bool((np.isin(np.diff(group), (0, 1))).all() and group[0] == 0)


def test_with_enough_recordings_each_is_a_group():
    which, group = grouped(*[20.0] * 5)
    np.testing.assert_array_equal(group, which)
    which, group = grouped(*[20.0] * 7)
    np.testing.assert_array_equal(group, which)


@pytest.mark.parametrize(("recordings", "spans"), [(1, 5), (2, 3), (3, 2), (4, 2)])
def test_few_are_cut_into_spans(recordings, spans):
    which, group = grouped(*[20.0] * recordings)
    assert contiguous(group)
    assert group.max() + 1 == recordings * spans >= POLICY.groups
    for g in range(group.max() + 1):
        assert np.unique(which[group == g]).size == 1  # no group reaches over two recordings
    sizes = np.bincount(group)
    assert sizes.max() - sizes.min() <= 1


def test_spans_last_a_few_periods_at_least():
    """Unless there would be too few to tell one cause from another: then a period will do."""
    short = 1.9 * POLICY.periods * PERIOD
    assert grouped(short)[1].max() + 1 == POLICY.fewest
    assert grouped(short, short)[1].max() + 1 == 4  # two spans each, for three groups or more
    assert grouped(short, short, short)[1].max() + 1 == 3
    assert grouped(1.5 * PERIOD)[1].max() == 0  # too short for two periods
    _, group = grouped(short, 20.0)
    assert group.max() + 1 == 2 + 3
    assert grouped(0.1, 0.1, 0.1)[1].tolist() == [0, 1, 2]


def test_what_differs_between_recordings_is_judged_within_them():
    which, group = grouped(*[20.0] * 6, within=True)
    assert contiguous(group)
    for r in range(6):
        assert np.unique(group[which == r]).size == 2


def test_recordings_that_were_not_fitted_have_no_group():
    which, group = grouped(20.0, 20.0, 20.0, 20.0, 20.0, 20.0, recordings=(0, 1, 3, 4, 5))
    assert contiguous(group)
    assert [int(np.unique(group[which == r])[0]) for r in (0, 1, 3, 4, 5)] == [0, 1, 2, 3, 4]


def test_never_more_spans_than_windows():
    prepared = [types.SimpleNamespace(t=np.linspace(0.0, 100.0, 50))]
    windows = types.SimpleNamespace(recording=np.zeros(3, dtype=int), n=3)
    setting = standing_in(PreparedCampaign, prepared=prepared, period=PERIOD)
    fit = standing_in(Fit, problem=types.SimpleNamespace(windows=windows))
    assert groups(setting, fit, POLICY).tolist() == [0, 1, 2]
