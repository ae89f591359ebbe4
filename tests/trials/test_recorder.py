"""Sensors with coloured noise, coarse converters, a measured drive."""

import dataclasses

import numpy as np
import pytest

from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign
from tp_jax.rig import BENCH, VirtualRig
from trials.recorded import record_campaign
from trials.recorder import DriveSensor, Recorder, Sensor, rounded

PLAN = (
    {"omega": 12.0, "duration": 2.0, "swing": 0.5},
    {"release": -0.6, "duration": 3.0},
)
QUIET = Sensor(0.0, bits=30)
N = 100_000


def noise_of(sensor: Sensor) -> np.ndarray:
    return sensor.read(np.zeros(N), np.random.default_rng(0)) - sensor.zero


def test_noise_has_its_colour():
    sensor = Sensor(1e-3, 2e-3, (0.9, -0.2), bits=24, zero=0.03)
    x = noise_of(sensor)
    assert x.std() == pytest.approx(sensor.rms, rel=0.02)
    assert sensor.rms == pytest.approx(np.sqrt(5) * 1e-3, rel=1e-3)
    lag_one = np.corrcoef(x[1:], x[:-1])[0, 1]
    assert lag_one == pytest.approx(sensor.lag_one, abs=0.02)
    assert sensor.lag_one == pytest.approx(0.8 * 0.9 / 1.2)


def test_slow_noise_is_that_of_long_means():
    for ar in ((0.8, 0.0), (0.5, 0.3), (0.6, -0.4)):
        sensor = Sensor(1e-3, 1e-3, ar, bits=24)
        means = noise_of(sensor).reshape(-1, 200).mean(axis=1)
        assert means.std() * np.sqrt(200) == pytest.approx(sensor.slow, rel=0.1)
    assert Sensor(1e-3, bits=24).slow == pytest.approx(1e-3)


def test_a_coarse_converter():
    sensor = Sensor(1e-5, bits=10)
    y = sensor.read(np.linspace(-9.0, 9.0, 5000), np.random.default_rng(0))
    np.testing.assert_allclose(y / sensor.step, np.round(y / sensor.step), atol=1e-9)
    assert sensor.step == pytest.approx(6.136e-3, rel=1e-3)
    assert rounded(np.array([0.24, 0.26]), 0.5).tolist() == [0.0, 0.5]


def test_noise_that_grows_is_refused():
    with pytest.raises(InputError, match="not stationary"):
        Sensor(1e-3, 1e-3, (1.2, 0.0))


def test_commanded(tmp_path):
    zeros = dict(sensor1=dataclasses.replace(QUIET, zero=0.02), sensor2=QUIET)
    plan = [{**PLAN[0], "swing": 1.0}, PLAN[1]]
    recorder = Recorder(100.0, **zeros, with_B1=False)
    key = record_campaign(tmp_path, BENCH, {}, {}, plan, recorder, 3)
    campaign = load_campaign(tmp_path)
    assert campaign.B1 is None
    assert [r.n for r in campaign.recordings] == [201, 301]
    assert [r.forced for r in campaign.recordings] == [True, False]
    assert campaign.recordings[0].omega == 12.0
    ideal = VirtualRig().run(campaign.recordings[0].t, omega=12.0)
    np.testing.assert_allclose(campaign.recordings[0].phi1, ideal[:, 0] + 0.02, atol=1e-8)
    assert key["recorder"]["sensor1"]["zero"] == 0.02
    assert key["runs"][1]["release"] == -0.6


@pytest.mark.parametrize("metered", [True, False])
def test_measured(tmp_path, metered):
    drive = DriveSensor(gain=-2.0, offset=0.7, noise=0.0, bits=30)
    recorder = Recorder(100.0, QUIET, QUIET, drive, decays_metered=metered)
    record_campaign(tmp_path, BENCH, {}, {}, PLAN, recorder, 3)
    forced, decay = load_campaign(tmp_path).recordings
    arm = 0.5 * BENCH.A * np.sin(12.0 * forced.t)
    np.testing.assert_allclose(forced.drive, 0.7 - 2.0 * arm, atol=1e-7)
    assert forced.omega is None
    assert forced.measured_drive
    assert decay.measured_drive is metered
    assert not decay.forced
    half = VirtualRig(dataclasses.replace(BENCH, A=0.5 * BENCH.A)).run(forced.t, omega=12.0)
    np.testing.assert_allclose(forced.phi1, half[:, 0], atol=1e-8)


def test_column_alone(tmp_path):
    single = dataclasses.replace(BENCH, B2=0.0)
    record_campaign(tmp_path, single, {}, {}, PLAN, Recorder(100.0, QUIET, QUIET), 3)
    campaign = load_campaign(tmp_path)
    assert campaign.model == "single"
    assert campaign.recordings[0].phi2 is None
