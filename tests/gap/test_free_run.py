"""Free runs over recordings with gaps."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import lossy, synthetic_campaign, synthetic_values
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.gap.free_run import free_run, start_state
from tp_jax.recordings import stretches

NOISE = 1e-4


# the first is in the window that the start is taken from, the second leaves three samples of it
@pytest.mark.parametrize("lost", [(0.2, 0.5), (0.011, 0.3)])
def test_goes_on_through_a_gap_at_its_beginning(lost):
    campaign = synthetic_campaign(NOISE)
    runs = list(campaign.recordings)
    runs[1] = dataclasses.replace(lossy(runs[1], 0, lost), held_out=True)
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)), effects=())
    assert stretches(runs[1].t)[0].stop < 8 or lost[0] > 0.1
    values = synthetic_values(setting)
    readings = free_run(setting, values, (), 1, start_state(setting, values, 1, 0.75))
    assert readings.shape == (runs[1].n, 2)
    error = readings - np.stack([runs[1].phi1, runs[1].phi2], axis=1)
    assert np.sqrt(np.mean(error**2)) < 2.0 * NOISE


def test_start_does_not_look_beyond_a_gap():
    campaign = synthetic_campaign(NOISE)
    run = lossy(campaign.recordings[1], 0, (0.2, 0.5))
    later = run.t > 0.3
    elsewhere = dataclasses.replace(run, phi2=run.phi2 + np.pi * later)  # a branch lost in the gap
    states = []
    for each in (run, elsewhere):
        runs = (campaign.recordings[0], each, campaign.recordings[2])
        setting = prepare_campaign(dataclasses.replace(campaign, recordings=runs), effects=())
        states.append(start_state(setting, synthetic_values(setting), 1, 0.75))
    np.testing.assert_array_equal(*states)
