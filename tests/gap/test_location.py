"""Where the gap lies, found without naming a cause."""

import dataclasses

import numpy as np
import pytest

from tests.rigs import synthetic_campaign, synthetic_values
from tp_jax.estimation.baseline import prepare_campaign
from tp_jax.estimation.blocks import blocks_of
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.least_squares import fit as fit_windows
from tp_jax.estimation.problem import spread
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
        setting.problem(setting.horizons[-1]), synthetic_values(setting), setting.unknowns(),
        bounds=setting.bounds, anchors=setting.anchors(),
    )  # fmt: skip
    free = free_columns(setting, fit)
    jac = np.concatenate([free.jac, spread(fit.linearisation, list(fit.unknowns))], axis=2)
    left = eliminate(fit.linearisation.r, fit.linearisation.states_jac, jac)
    return attribute(VarianceComponents(left, free.source), blocks_of(fit, setting))


@pytest.mark.parametrize("sensor", [1, 2])
def test_a_sensor_that_reads_wrong(sensor):
    found = located(with_error(sensor, 0.5))
    assert found.channels[0] == f"sensor{sensor}"
    assert found.shares[0] > 0.6


def test_a_late_channel():
    campaign = synthetic_campaign()
    late = tuple(
        dataclasses.replace(r, phi2=np.interp(r.t - 1e-3, r.t, r.phi2)) for r in campaign.recordings
    )
    found = located(dataclasses.replace(campaign, recordings=late))
    assert found.channels[0] == "clock"
