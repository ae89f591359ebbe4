"""tp-jax calibrate: readings at known angles to a file that `record` takes."""

import json
import re

import numpy as np
import pytest

from tp_jax.acquisition import read_calibration
from tp_jax.cli import main
from tp_jax.cli.calibrate import LAWS
from tp_jax.recordings.calibration import PARAMETERS

KNOWN = np.deg2rad(np.arange(-40.0, 41.0, 5.0))


def write(path, scale=1.0, **columns):
    """A calibration run; the known angles, phi1 and phi2, are divided by the scale."""
    values = [v / scale if name.startswith("phi") else v for name, v in columns.items()]
    np.savetxt(path, np.column_stack(values), delimiter=",", header=",".join(columns), comments="")
    return str(path)


def bridges(offset, gain, seed=0):
    """Volts of a sine and a cosine bridge, with 1 mV of noise."""
    rng = np.random.default_rng(seed)
    sine = offset + 0.5 * gain * np.sin(2.0 * KNOWN) + 1e-3 * rng.normal(size=KNOWN.size)
    cosine = offset + 0.5 * gain * np.cos(2.0 * KNOWN) + 1e-3 * rng.normal(size=KNOWN.size)
    return sine, cosine


@pytest.fixture
def runs(tmp_path):
    sine, cosine = bridges(1.65, 2.6)
    one = write(tmp_path / "one.csv", phi1=KNOWN, sine1=sine, cosine1=cosine)
    two = write(tmp_path / "two.csv", phi2=KNOWN, sine2=bridges(1.6, 2.4, 1)[0])
    return one, two


def test_laws_are_those_of_the_package():
    assert set(LAWS) == set(PARAMETERS)


def test_both_sensors(runs, tmp_path, capsys):
    out = tmp_path / "new" / "rig.toml"
    assert main(["calibrate", *runs, "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    lines = told.out.split("\n")
    assert lines[0] == "phi1: law sine_cosine, 17 readings, -0.6981 to 0.6981 rad"
    offset = re.fullmatch(r"  offset        ([\d.]+) ± 0\.0+[1-9]\d V", lines[1])
    assert float(offset[1]) == pytest.approx(1.65, abs=2e-3)
    assert "phi2: law sine, 17 readings" in told.out
    assert "Beware" not in told.out
    assert lines[-2] == f"Wrote {out}; use it with tp-jax record --calibration {out}"
    found = read_calibration(out).sensors
    assert found["phi1"].parameters["gain"] == pytest.approx(2.6, abs=0.01)
    assert found["phi2"].parameters["gain"] == pytest.approx(2.4, abs=0.01)
    assert 0.0 < found["phi2"].errors["gain"] < 0.01
    assert [each.name for each in out.parent.iterdir()] == ["rig.toml"]


def test_one_file_with_both_and_in_degrees(runs, tmp_path):
    sine, cosine = bridges(1.65, 2.6)
    file = write(
        tmp_path / "d.csv",
        np.pi / 180.0,
        phi1=KNOWN,
        sine1=sine,
        phi2=KNOWN,
        sine2=sine,
        cosine2=cosine,
    )
    out, other = str(tmp_path / "d.toml"), str(tmp_path / "r.toml")
    assert main(["calibrate", file, "--degrees", "--quiet", "--out", out]) == 0
    found = read_calibration(out).sensors
    assert {name: sensor.law for name, sensor in found.items()} == {
        "phi1": "sine",
        "phi2": "sine_cosine",
    }
    assert main(["calibrate", runs[0], "--quiet", "--out", other]) == 0
    np.testing.assert_allclose(
        found["phi2"].values, read_calibration(other).sensors["phi1"].values, atol=1e-9
    )


def test_runs_of_one_sensor_are_put_together(runs, tmp_path):
    out = tmp_path / "rig.toml"
    sine, cosine = bridges(1.65, 2.6, seed=3)
    again = write(tmp_path / "again.csv", phi1=KNOWN, sine1=sine, cosine1=cosine)
    assert main(["calibrate", runs[0], again, "--quiet", "--out", str(out)]) == 0
    both = read_calibration(out).sensors["phi1"]
    assert main(["calibrate", runs[0], "--quiet", "--out", str(out), "--overwrite"]) == 0
    one = read_calibration(out).sensors["phi1"]
    assert both.errors["gain"] < one.errors["gain"]


def test_a_calibration_is_not_replaced_unless_told(runs, tmp_path, capsys):
    out = tmp_path / "rig.toml"
    out.write_text("mine")
    argv = ["calibrate", runs[0], "--out", str(out)]
    assert main(argv) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert main([*argv, "--overwrite", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert read_calibration(out).sensors["phi1"].law == "sine_cosine"
    # and a run that cannot be used leaves what is there
    assert main(["calibrate", runs[1], "--out", str(out), "--overwrite"]) == 2
    assert read_calibration(out).sensors["phi1"].law == "sine_cosine"


def test_the_result_alone(runs, tmp_path, capsys):
    out = tmp_path / "rig.toml"
    argv = ["calibrate", runs[0], "--law", "sine", "--out", str(out), "--json", "-"]
    assert main(argv) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["schema"] == "tp-jax/calibration/1"
    assert result["phi1"]["law"] == "sine"
    assert result["phi1"]["span"] == [KNOWN[0], KNOWN[-1]]
    assert 0.0 < result["phi1"]["standard_error"]["largest"] < 0.01


def test_a_law_that_is_not_the_sensors_is_told(runs, tmp_path, capsys):
    out = str(tmp_path / "rig.toml")
    assert main(["calibrate", runs[0], "--law", "line", "--out", out]) == 0
    assert "Beware: the scatter follows the angle" in capsys.readouterr().out


def test_the_recorder_takes_it(runs, tmp_path):
    rig, out = str(tmp_path / "rig.toml"), tmp_path / "run.csv"
    assert main(["calibrate", *runs, "--quiet", "--out", rig]) == 0
    argv = ["record", "--port", "emulator", "--speed", "max", "--duration", "0.5", "--quiet"]
    assert main([*argv, "--omega", "10", "--calibration", rig, "--out", str(out)]) == 0
    meta = json.loads((tmp_path / "run.csv.meta.json").read_text())
    assert meta["calibration"]["source"] == rig


@pytest.mark.parametrize(
    ("text", "more", "part"),
    [
        (None, [], "no such file"),
        ("", [], "empty"),
        ("a,b\n1,2\n", [], "header like phi1,sine1,cosine1"),
        ("phi1\n1\n", [], "add a column sine1"),
        ("sine1,cosine1\n1,2\n", [], "add a column phi1"),
        ("phi1,sine1,cosin1\n1,2,3\n", [], 'did you mean "cosine1"?'),
        ("phi1,sine1\n0,1\n0.1\n", [], "line 3: the row has 1 cells"),
        ("phi1,sine1\n0,1\n0.1,x\n", [], 'line 3: sine1 is no number but "x"'),
        ("phi1,sine1\n0,nan\n", [], "sine1 is no number"),
        ("phi1,sine1\n0,1\n10,2\n20,3\n", [], "add --degrees"),
        ("phi1,sine1\n0,1\n0.1,2\n0.2,3\n", ["--degrees"], "leave out --degrees"),
        ("phi1,sine1\n0,1\n0.1,2\n0.2,3\n", ["--law", "sine_cosine"], "cosine1"),
        ("phi1,sine1\n0,1\n", [], "more angles"),
        ("phi1,sine1\n", [], "more angles"),
        ("phi2,sine2\n0,1\n0.1,2\n0.2,3\n", [], "column phi1"),
        ("phi1,sine1\n0,1\n0.1,2\n0.2,3\n", ["--law", "cubic"], "--law"),
    ],
)
def test_faults_are_told_in_one_sentence(text, more, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    if text is not None:
        (tmp_path / "a.csv").write_text(text)
    assert main(["calibrate", "a.csv", "--out", "rig.toml", *more]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("tp-jax: ")
    assert told.err.count("\n") == 1
    assert part in told.err
    assert not (tmp_path / "rig.toml").exists()


def test_the_readings_are_not_written_over(runs, capsys):
    argv = ["calibrate", runs[0], "--out", runs[0], "--overwrite"]
    assert main(argv) == 2
    assert "replace the readings" in capsys.readouterr().err
