"""Volts to angles, the fit, the error of the angle, and the file."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition import read_calibration, write_calibration
from tp_jax.errors import InputError
from tp_jax.recordings.calibration import Calibration, SensorCalibration, nominal
from tp_jax.recordings.calibration_run import fit_calibration

VALUES = {
    "line": [1.65, 2.6],
    "sine": [1.65, 2.6],
    "sine_cosine": [1.652, 2.61, 1.638, 2.58, 0.012],
}
RANGE = {"line": 0.7, "sine": 0.7, "sine_cosine": 1.5}


def made(law, errors=None):
    values = np.array(VALUES[law])
    errors = np.full(values.size, 1e-3) if errors is None else np.array(errors)
    return SensorCalibration(law, values, np.diag(errors**2))


@pytest.mark.parametrize("law", VALUES)
@given(st.floats(-1.0, 1.0))
def test_there_and_back(law, part):
    angle = np.array([part * RANGE[law]])
    sensor = made(law)
    np.testing.assert_allclose(sensor.angle(sensor.volts(angle)), angle, atol=1e-9)


def test_the_laws_are_the_bridges():
    angle = np.deg2rad([0.0, 15.0, 45.0])
    sine = made("sine").volts(angle)[:, 0]
    np.testing.assert_allclose(sine, 1.65 + 2.6 * 0.5 * np.sin(2 * angle))
    # read by the paper's straight line it is 4.5 % low at 15 degrees and 36 % at 45
    read = made("line").angle(made("sine").volts(angle))
    np.testing.assert_allclose(1.0 - read[1:] / angle[1:], [0.0451, 0.3634], atol=1e-4)


def test_beyond_the_range_of_one_bridge():
    assert made("sine").angle([[9.0, 0.0]])[0] == pytest.approx(np.pi / 4)


@pytest.mark.parametrize("law", VALUES)
def test_the_standard_error_is_what_the_parameters_scatter(law):
    rng = np.random.default_rng(0)
    p = len(VALUES[law])
    root = 1e-3 * rng.normal(size=(p, p))
    sensor = SensorCalibration(law, np.array(VALUES[law]), root @ root.T)
    angle = np.linspace(-0.9, 0.9, 7) * RANGE[law]
    seen = sensor.volts(angle)
    drawn = rng.multivariate_normal(sensor.values, sensor.covariance, 20000)
    read = np.array([SensorCalibration(law, v, sensor.covariance).angle(seen) for v in drawn])
    np.testing.assert_allclose(sensor.standard_error(angle), read.std(axis=0), rtol=0.05)
    # and its modes are how the errors of different angles go together
    modes = sensor.error_modes(angle)
    together = np.cov(read, rowvar=False)
    np.testing.assert_allclose(modes.T @ modes, together, atol=0.03 * together.max())


def test_the_error_grows_towards_the_fold():
    error = made("sine").standard_error([0.0, 0.6, np.pi / 4])
    assert error[0] < error[1] < error[2] == np.inf
    flat = made("sine_cosine").standard_error(np.linspace(-1.5, 1.5, 50))
    assert flat.max() < 2.5 * flat.min()
    unknown = SensorCalibration("sine", np.array([1.65, 2.6]), np.zeros((2, 2)))
    assert not unknown.standard_error([0.0, np.pi / 4]).any()


@pytest.mark.parametrize("law", VALUES)
def test_a_fit_finds_the_law_and_its_errors(law):
    rng = np.random.default_rng(1)
    true, noise, off = made(law), 2e-3, []
    angle = np.linspace(-1.0, 1.0, 25) * RANGE[law]
    for _ in range(60):
        seen = true.volts(angle) + noise * rng.normal(size=(25, 2))
        fit = fit_calibration(angle, seen, law)
        off.append((fit.values - true.values) / np.sqrt(np.diag(fit.covariance)))
        assert fit.residual == pytest.approx(noise, rel=0.6)
    assert fit.span == (angle[0], angle[-1])
    # in standard errors: mean 0, standard deviation 1
    assert np.abs(np.mean(off, axis=0)).max() < 0.5
    assert np.all(np.abs(np.std(off, axis=0) - 1.0) < 0.35)


def test_a_fit_with_a_zero_far_away():
    sensor = SensorCalibration("sine_cosine", np.array([1.6, 2.5, 1.7, 2.4, 1.2]), np.zeros((5, 5)))
    angle = np.linspace(-0.6, 0.6, 30)
    fit = fit_calibration(angle, sensor.volts(angle))
    np.testing.assert_allclose(fit.values, sensor.values, atol=1e-6)


@pytest.mark.parametrize(
    ("angles", "readings", "law", "part"),
    [
        ([0, 1], [0, 1], "cubic", "one of"),
        ([0, 1, 2], [0, 1], "line", "shapes"),
        ([0, 1, 2], [0, 1, 2], "sine_cosine", "(n, 2) readings"),
        ([0, 1, np.nan], [0, 1, 2], "line", "finite"),
        ([0, 0, 0], [1, 1, 1], "line", "more angles"),
        (np.linspace(0, 1e-7, 9), np.ones((9, 2)), "sine_cosine", ""),
        (
            np.linspace(-1, 1, 20),
            -made("sine_cosine").volts(np.linspace(-1, 1, 20)),
            "sine_cosine",
            "",
        ),
    ],
)
def test_what_cannot_be_fitted(angles, readings, law, part):
    if law == "sine_cosine" and np.ndim(readings) == 2 and np.ptp(readings) > 1:
        # a bridge turned round: the other sign is half a turn away, if both are; one is a fault
        readings = np.array(readings)
        readings[:, 0] *= -1.0
    with pytest.raises(InputError) as told:
        fit_calibration(angles, readings, law)
    assert part in str(told.value)


def test_the_file(tmp_path):
    angle = np.linspace(-1.0, 1.0, 25)
    rng = np.random.default_rng(2)
    true = made("sine_cosine")
    fit = fit_calibration(angle, true.volts(angle) + 1e-3 * rng.normal(size=(25, 2)))
    path = tmp_path / "rig.toml"
    write_calibration(path, Calibration({"phi1": fit, "phi2": made("line")}))
    back = read_calibration(path)
    assert back.source == str(path)
    assert list(back.sensors) == ["phi1", "phi2"]
    np.testing.assert_array_equal(back.sensors["phi1"].values, fit.values)
    np.testing.assert_array_equal(back.sensors["phi1"].covariance, fit.covariance)
    assert back.sensors["phi1"].span == fit.span
    assert back.sensors["phi1"].residual == fit.residual
    assert back.sensors["phi2"].residual is None


def test_a_file_written_by_hand(tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text('[phi1]\nlaw = "sine"\noffset = 1\ngain = 2.5\nerrors = { gain = 0.01 }\n')
    sensor = read_calibration(path).sensors["phi1"]
    assert sensor.parameters == {"offset": 1.0, "gain": 2.5}
    assert sensor.errors == {"offset": 0.0, "gain": 0.01}


SINE = '[phi1]\nlaw = "sine"\noffset = 1\n'


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("= 3", "is not TOML"),
        ("", "phi1 is missing"),
        ("[phi3]\n", "phi1 is missing"),
        ("phi1 = 3", "phi1 must be a table, but is 3"),
        ('[phi1]\nlaw = "cubic"', "cubic"),
        (SINE, "phi1.gain is missing"),
        (SINE + "gain = true", "phi1.gain must be a number, but is true"),
        (SINE + "gain = nan", "phi1.gain must be between"),
        (SINE + "gain = 0", "gain is 0"),
        (SINE + "gain = 1\nslope = 2", "phi1.slope is unknown"),
        (SINE + "gain = 1\nspan = 3", "span"),
        (SINE + "gain = 1\nerrors = { slope = 1 }", "errors"),
        (SINE + "gain = 1\ncovariance = [[1, 2]]", "phi1.covariance must be 2 rows of 2"),
        (SINE + "gain = 1\ncovariance = [[1, 2], [3, 4]]", "symmetric"),
        (SINE + "gain = 1\ncovariance = [[1, 2], [2, 1]]", "symmetric"),
    ],
)
def test_files_that_are_no_calibration(text, part, tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text(text)
    with pytest.raises(InputError) as told:
        read_calibration(path)
    assert part in str(told.value)
    assert str(path) in str(told.value)
    with pytest.raises(InputError, match="Cannot read"):
        read_calibration(tmp_path / "nowhere.toml")


def test_nominal_values_say_how_little_is_known():
    for cosine in (False, True):
        sensor = nominal(3.3, cosine)
        assert sensor.needs_cosine is cosine
        assert 0.02 < sensor.standard_error([0.0])[0] < 0.1
