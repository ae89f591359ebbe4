"""Means of blocks in the place of samples that no motion needs."""

import dataclasses

import numpy as np
import pytest

from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.recordings import Campaign, Recording, block_length, stretches, thinned
from tp_jax.recordings.noise import is_coarse, quantum

OMEGA = 13.0
PERIOD = 2.0 * np.pi / OMEGA


def recorded(rate: float, duration: float = 4.0, lost: slice = slice(0)) -> Recording:
    t = np.delete(np.arange(round(rate * duration)) / rate, lost)
    rng = np.random.default_rng(0)
    noise = 1e-3 * rng.standard_normal((2, t.size))
    return Recording.from_arrays(
        t, 0.5 * np.sin(OMEGA * t) + noise[0], 0.3 * np.cos(OMEGA * t) + noise[1], omega=OMEGA
    )


@pytest.mark.parametrize(("rate", "length"), [(250.0, 1), (1000.0, 1), (2000.0, 3), (10_000.0, 18)])
def test_as_many_as_a_period_needs_stay(rate, length):
    assert block_length(recorded(rate), PERIOD) == length


def test_means_are_of_the_same_motion_with_less_noise():
    fine = recorded(10_000.0)
    coarse = thinned(fine, 18)
    assert coarse.n == fine.n // 18
    left = coarse.phi1 - 0.5 * np.sin(OMEGA * coarse.t)
    assert left.std() == pytest.approx(1e-3 / np.sqrt(18), rel=0.1)
    # (w h)^2 / 24 of the amplitude
    assert abs(left @ np.sin(OMEGA * coarse.t)) / coarse.n < 1e-4


def test_no_block_reaches_across_a_gap():
    fine = recorded(10_000.0, lost=slice(12_345, 20_001))
    coarse = thinned(fine, 18)
    assert len(stretches(fine.t)) == len(stretches(coarse.t)) == 2
    left = coarse.phi1 - 0.5 * np.sin(OMEGA * coarse.t)
    assert np.abs(left).max() < 2e-3


def test_a_recording_without_samples_to_spare_is_left_alone():
    fine = recorded(250.0)
    assert thinned(fine, block_length(fine, PERIOD)) is fine


def test_of_coarse_readings_one_stands_for_a_block():
    """Their means would come in finer steps, which seem to hide nothing.

    Seen on a rig with nothing hidden, whose converter of 10 bits was read 852 times a second.
    """
    step = 2.0 * np.pi / 1024
    fine = recorded(2000.0)
    rough = dataclasses.replace(fine, phi2=step * np.round(fine.phi2 / step))
    assert not is_coarse(fine)
    assert is_coarse(rough)
    taken = thinned(rough, 3, coarse=True)
    assert quantum(taken.phi2) == pytest.approx(step)
    assert quantum(thinned(rough, 3).phi2) < 0.5 * step
    assert set(taken.t) <= set(rough.t)
    np.testing.assert_array_equal(taken.phi2, rough.phi2[1::3][: taken.n])


def test_a_campaign_is_thinned_by_what_its_coarsest_readings_allow():
    step = 2.0 * np.pi / 1024
    runs = []
    for i in range(2):
        fine = recorded(2000.0)
        rough = step * np.round(fine.phi2 / step) if i else fine.phi2
        runs.append(dataclasses.replace(fine, phi2=rough, name=f"run-{i}", label=f"run-{i}"))
    setting = prepare_campaign(Campaign.from_arrays(runs), effects=())
    assert setting.coarse
    assert set(setting.blocks) == {3}
    assert quantum(setting.recordings[1].phi2) == pytest.approx(step)
    setting = prepare_campaign(Campaign.from_arrays(runs[:1]), effects=())
    assert not setting.coarse
    assert setting.levels[0, 0] == pytest.approx(1e-3 / np.sqrt(3.0), rel=0.1)
