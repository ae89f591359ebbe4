"""The calibration's error, from the metadata beside a recording."""

import json

import numpy as np
import pytest

from tp_jax.acquisition.run_log import metadata_path, write_metadata
from tp_jax.recordings import CalibrationError, CampaignError, load_campaign
from tp_jax.recordings.calibration import Calibration, SensorCalibration, calibration_entry
from tp_jax.schemas.recording import VERSION

SINE = SensorCalibration("sine", np.array([1.65, 2.6]), np.array([[4e-6, 1e-6], [1e-6, 9e-4]]))
BOTH = SensorCalibration(
    "sine_cosine",
    np.array([1.65, 2.6, 1.64, 2.58, 0.01]),
    np.diag([2e-3, 0.02, 1e-3, 0.03, 0.0]) ** 2,
)


def beside(recording, span=(-0.5, 0.5), phi1=SINE, phi2=BOTH):
    """Writes the metadata that `record` would write."""
    entry = calibration_entry(
        Calibration({"phi1": phi1, "phi2": phi2}, "rig.toml"), {"phi1": span, "phi2": span}
    )
    write_metadata(recording, {"schema": VERSION, "calibration": entry})


def test_what_was_recorded_is_read_back(campaign_folder):
    beside(campaign_folder / "run-13.csv")
    beside(campaign_folder / "run-17.csv", span=(-0.4, 0.3))
    campaign = load_campaign(campaign_folder)
    errors = {each.name: each.calibration_error for each in campaign.recordings}
    assert errors["decay.csv"] == errors["run-06.csv"] == {}
    angle = np.linspace(-0.4, 0.3, 40)
    for name, sensor in (("phi1", SINE), ("phi2", BOTH)):
        here, there = errors["run-13.csv"][name], errors["run-17.csv"][name]
        np.testing.assert_allclose(
            here.standard_error(angle), sensor.standard_error(angle), rtol=0.02
        )
        # the same shapes, and not only the same size
        np.testing.assert_allclose(here.at(angle), there.at(angle), atol=2e-5)
        assert here.key == there.key
        measured = np.gradient(sensor.error_modes(angle), angle, axis=1)
        measured = measured[sensor.error_modes(angle).any(axis=1)]
        np.testing.assert_allclose(
            here.slope(angle[2:-2]), measured[:, 2:-2], atol=0.05 * np.abs(measured).max()
        )
    part = next(r for r in campaign.recordings if r.name == "run-13.csv").cut(0.0, 1.0)
    assert part.calibration_error is errors["run-13.csv"]


def test_another_calibration_has_another_key(campaign_folder):
    beside(campaign_folder / "run-13.csv")
    other = SensorCalibration("sine", SINE.values + 0.01, SINE.covariance)
    beside(campaign_folder / "run-17.csv", phi1=other)
    here, there = (load_campaign(campaign_folder).recordings[i].calibration_error for i in (2, 3))
    assert here["phi1"].key != there["phi1"].key
    assert here["phi2"].key == there["phi2"].key


def test_a_ring_that_winds():
    grid = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 25)
    error = CalibrationError("", grid, BOTH.error_modes(grid))
    angle = np.array([0.3, 1.2, -1.4])
    np.testing.assert_allclose(error.at(angle + 7.0 * np.pi), error.at(angle), atol=1e-12)
    narrow = CalibrationError("", np.array([0.0, 1.0]), np.array([[1.0, 2.0]]))
    np.testing.assert_array_equal(narrow.at(np.array([-3.0, 0.5, 3.0])), [[1.0, 1.5, 2.0]])


def test_at_the_fold_the_nearest_angle_stands_for_it(campaign_folder):
    beside(campaign_folder / "run-13.csv", span=(-0.5, 0.25 * np.pi))
    error = load_campaign(campaign_folder).recordings[2].calibration_error["phi1"]
    assert np.isfinite(error.standard_error(np.linspace(-1.0, 1.0, 50))).all()


def test_a_calibration_without_errors_says_nothing(campaign_folder):
    exact = SensorCalibration("line", np.array([0.0, 1.0]), np.zeros((2, 2)))
    beside(campaign_folder / "run-13.csv", phi1=exact)
    assert list(load_campaign(campaign_folder).recordings[2].calibration_error) == ["phi2"]


def test_a_body_that_never_moved(campaign_folder):
    beside(campaign_folder / "run-13.csv", span=(0.1, 0.1))
    assert set(load_campaign(campaign_folder).recordings[2].calibration_error) == {"phi1", "phi2"}


def test_columns_of_ones_own_are_not_those_calibrated(campaign_folder, edit):
    beside(campaign_folder / "run-13.csv")
    edit(
        "campaign.toml",
        "[rig]",
        '[format.columns]\nt = { column = "t" }\nphi1 = { column = "phi1", scale = 2.0 }\n'
        'phi2 = { column = "phi2" }\n[rig]',
    )
    assert not any(each.calibration_error for each in load_campaign(campaign_folder).recordings)


@pytest.mark.parametrize(
    "content",
    [
        [],
        {"schema": "another/1", "calibration": 3},
        {"schema": VERSION},
        {"schema": VERSION, "calibration": {"source": "", "phi1": {"law": "sine"}}},
        {"schema": VERSION, "calibration": {"phi1": {"standard_error": {"largest": 0.1}}}},
    ],
)
def test_metadata_that_name_no_error(campaign_folder, content):
    metadata_path(campaign_folder / "run-13.csv").write_text(json.dumps(content))
    assert load_campaign(campaign_folder).recordings[2].calibration_error == {}


@pytest.mark.parametrize(
    "told",
    [
        "{",
        {"modes": [[1.0]]},
        {"angle": [0.0, 1.0], "modes": [[1.0]]},
        {"angle": [1.0, 0.0], "modes": [[1.0, 1.0]]},
        {"angle": [0.0, None], "modes": [[1.0, 1.0]]},
        {"angle": "ab", "modes": "c"},
    ],
)
def test_metadata_that_are_spoilt(campaign_folder, told):
    file = metadata_path(campaign_folder / "run-13.csv")
    content = {"schema": VERSION, "calibration": {"phi1": {"standard_error": told}}}
    file.write_text(told if isinstance(told, str) else json.dumps(content))
    with pytest.raises(CampaignError) as fault:
        load_campaign(campaign_folder)
    assert str(fault.value).startswith(f"{file}: ")
    assert "move the file away" in str(fault.value)
