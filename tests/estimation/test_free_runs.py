"""The objective (17), for many sets of numbers at once."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import lossy, synthetic_campaign, synthetic_values
from tp_jax.estimation.free_runs import FreeRuns, first_state
from tp_jax.estimation.prepared_campaign import prepare_campaign


@pytest.fixture(scope="module")
def setting():
    return prepare_campaign(synthetic_campaign(), effects=())


def test_at_the_truth_the_noise_is_left(setting):
    # half the sum of two mean squares of 1 mrad; the decay's angle is known to a part of that
    y = FreeRuns(setting)([synthetic_values(setting)])
    assert y == pytest.approx(1e-6, rel=0.1)


def test_it_is_17(setting):
    import tp_jax as tp
    from tp_jax.estimation.layout import Layout

    many = [synthetic_values(setting).replace({"k": k}) for k in (0.45, 0.46, 0.5)]
    many[2] = many[2].replace({"zero1": 0.01})
    found = FreeRuns(setting)(many)
    layout = Layout("double", ())
    for v, y in zip(many, found, strict=True):
        total = 0.0
        for r in setting.fitted:
            data = setting.prepared[r]
            p = v.table[: len(layout.parameters), r]
            zero = np.array([v.get("zero1"), v.get("zero2", r)])
            start = first_state(data, setting.recordings[r]) - [*zero, 0.0, 0.0]
            motion = tp.simulate(layout.model(tuple(p)), data.t, start)
            read = np.stack([motion.phi1, motion.phi2], axis=1) + zero
            total += 0.5 * ((read - data.y) ** 2).mean(axis=0).sum()
        assert y == pytest.approx(total / 3, rel=1e-3)


def test_numbers_that_are_nobodys_are_infinite(setting):
    mad = synthetic_values(setting).replace({"k": 1e9, "c1": 0.0})
    y = FreeRuns(setting)([mad, synthetic_values(setting)])
    assert y[0] == np.inf or y[0] > 1e-3
    assert np.isfinite(y[1])


def test_recordings_of_other_times_are_groups_of_their_own():
    campaign = synthetic_campaign(noise=1e-4)
    runs = [lossy(r, i, (0.5, 0.9)) if i else r for i, r in enumerate(campaign.recordings)]
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)), effects=())
    runs = FreeRuns(setting)
    assert [g.which for g in runs.groups] == [(0,), (1,), (2,)]
    assert runs([synthetic_values(setting)]) == pytest.approx(1e-8, rel=0.3)
    (whole,) = FreeRuns(prepare_campaign(campaign, effects=())).groups
    assert whole.which == (0, 1, 2)


def test_a_run_starts_from_rest_unless_the_readings_say_otherwise(setting):
    forced = setting.recordings[1]
    np.testing.assert_array_equal(first_state(setting.prepared[1], forced), 0.0)
    decay = first_state(setting.prepared[0], setting.recordings[0])
    assert decay[0] == pytest.approx(1.2, abs=5e-3)
    np.testing.assert_array_equal(decay[2:], 0.0)
    moving = setting.prepared[1].smooth.copy()
    moving[0] = [0.1, 0.0, 2.0, 0.0]
    state = first_state(dataclasses.replace(setting.prepared[1], smooth=moving), forced)
    np.testing.assert_array_equal(state, [0.1, 0.0, 2.0, 0.0])
