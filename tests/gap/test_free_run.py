"""Free runs: those of the pendulum itself, and over gaps."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import lossy, synthetic_campaign, synthetic_values
from tp_jax.effects import catalogue
from tp_jax.estimation.assemble import drive_for, fit_record, pendulum
from tp_jax.estimation.layout import SENSORS
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.gap.free_run import free_runs, start_state
from tp_jax.recordings import stretches
from tp_jax.simulation import simulate

NOISE = 1e-4


def test_are_those_of_the_pendulum_itself():
    """Of several recordings at once, longer than a lane, with what an effect remembers."""
    ids = ["contact_stribeck", "drive_backlash", "sensor2_nonlinearity"]
    effects = [catalogue()[id] for id in ids]
    campaign = synthetic_campaign(NOISE)
    runs = [dataclasses.replace(r, held_out=i > 0) for i, r in enumerate(campaign.recordings)]
    campaign = dataclasses.replace(campaign, recordings=tuple(runs))
    setting = dataclasses.replace(prepare_campaign(campaign, effects=effects), capacity=256)
    values = synthetic_values(setting)
    for effect in effects:
        values = values.replace({effect.qualified(a.name): a.typical for a in effect.amplitudes})
        values = values.replace({effect.qualified(s.name): s.grid[1] for s in effect.shapes})
    labels = [r.label for r in setting.recordings]
    record = fit_record(values, ids, labels)
    states = np.array([[0.1, 0.05, 0.3, -0.2], [0.0, 0.0, 1.0, 0.0]])
    found = free_runs(setting, values, [1, 2], states)
    for i, state, readings in zip((1, 2), states, found, strict=True):
        run = setting.recordings[i]
        drift = values.get("drift_middle", i), values.get("drift_rate", i)
        model = pendulum(record, drive_for(record, omega=run.omega), run.label, drift)
        own = np.zeros(model.n_states - 4)
        motion = simulate(model, run.t, np.concatenate([state, own]), tolerance=1e-9)
        sensing = tuple(term for term in model.terms if term.hook in SENSORS)
        y = (motion.phi1, motion.phi2, motion.omega1, motion.omega2)
        wanted = dataclasses.replace(model, terms=sensing).readings(motion.t, y)
        np.testing.assert_allclose(readings, np.stack(wanted, axis=1), atol=1e-5)


# the first is in the window that the start is taken from, the second leaves three samples of it
@pytest.mark.parametrize("lost", [(0.2, 0.5), (0.011, 0.3)])
def test_goes_on_through_a_gap_at_its_beginning(lost):
    campaign = synthetic_campaign(NOISE)
    runs = list(campaign.recordings)
    runs[1] = dataclasses.replace(lossy(runs[1], 0, lost), held_out=True)
    setting = prepare_campaign(dataclasses.replace(campaign, recordings=tuple(runs)), effects=())
    assert stretches(runs[1].t)[0].stop < 8 or lost[0] > 0.1
    values = synthetic_values(setting)
    start = start_state(setting, values, 1, 0.75)
    (readings,) = free_runs(setting, values, [1], start[None])
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
