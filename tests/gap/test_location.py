"""Where the gap lies, found without naming a cause."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.linearisation import spread
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.variable_projection import fit as fit_windows
from tp_jax.gap.free_torques import free_columns
from tp_jax.gap.variance_components import VarianceComponents, attribute


def with_error(sensor: int, a: float):
    """A campaign of which one sensor reads by a wrong law."""
    campaign = synthetic_campaign(noise=2e-4)
    runs = []
    for r in campaign.recordings:
        name = f"phi{sensor}"
        y = getattr(r, name)
        runs.append(dataclasses.replace(r, **{name: y + a * (0.5 * np.sin(2.0 * y) - y)}))
    return dataclasses.replace(campaign, recordings=tuple(runs))


def located(campaign):
    setting = prepare_campaign(campaign, effects=())
    fit = fit_windows(
        setting.problem(setting.horizons[-1]),
        synthetic_values(setting),
        setting.unknowns(),
        bounds=setting.bounds,
        priors=setting.priors(),
    )
    free = free_columns(setting, fit)
    jac = np.concatenate([free.jac, spread(fit.linearisation, list(fit.unknowns))], axis=2)
    left = eliminate(fit.linearisation.r, fit.linearisation.states_jac, jac)
    return attribute(VarianceComponents(left, free.source, free.weight), blocks_of(fit, setting))


@pytest.mark.parametrize("sensor", [1, 2])
def test_a_sensor_that_reads_wrong(sensor):
    found = located(with_error(sensor, 0.5))
    assert found.channels[0] == f"sensor{sensor}"
    assert found.shares[0] > 0.6


def test_a_reading_that_freezes():
    """For 60 ms, four times a second: no torque can do that."""
    campaign = synthetic_campaign()
    runs = []
    for r in campaign.recordings:
        held = np.floor(r.t / 0.25) * 0.25
        at = np.where(r.t - held < 0.06, held, r.t)
        runs.append(dataclasses.replace(r, phi2=np.interp(at, r.t, r.phi2)))
    found = located(dataclasses.replace(campaign, recordings=tuple(runs)))
    assert found.channels[0] == "sensor2"
    assert found.shares[0] > 0.6


def test_a_zero_that_wanders():
    rng = np.random.default_rng(0)
    campaign = synthetic_campaign()
    runs = []
    for r in campaign.recordings:
        walk = np.cumsum(rng.normal(size=r.t.size) * np.sqrt(np.gradient(r.t)))
        runs.append(dataclasses.replace(r, phi1=r.phi1 + 0.01 * walk))
    found = located(dataclasses.replace(campaign, recordings=tuple(runs)))
    assert found.channels[0] == "sensor1"
    assert found.alone["sensor1"].sources == ("sensor1 wandering",)


def test_times_that_are_off_for_both():
    rng = np.random.default_rng(1)
    campaign = synthetic_campaign()
    runs = []
    for r in campaign.recordings:
        at = r.t + 2e-3 * np.abs(rng.normal(size=r.t.size))
        both = {name: np.interp(at, r.t, getattr(r, name)) for name in ("phi1", "phi2")}
        runs.append(dataclasses.replace(r, **both))
    found = located(dataclasses.replace(campaign, recordings=tuple(runs)))
    assert found.channels[0] == "clock"
    assert found.alone["clock"].sources == ("clock jumping",)


def test_a_late_channel():
    campaign = synthetic_campaign()
    late = tuple(
        dataclasses.replace(r, phi2=np.interp(r.t - 1e-3, r.t, r.phi2)) for r in campaign.recordings
    )
    found = located(dataclasses.replace(campaign, recordings=late))
    assert found.channels[0] == "clock"
