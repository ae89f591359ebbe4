"""The reference sketches, compiled for this computer, behind a pseudo-terminal."""

import os
import shutil
import subprocess
import tty
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tp_jax.acquisition import Settings, record
from tp_jax.acquisition.port import Port
from tp_jax.errors import InputError
from tp_jax.recordings import read_columns

HERE = Path(__file__).parent
FIRMWARE = HERE.parents[1] / "tp_jax" / "acquisition" / "firmware"

pytestmark = pytest.mark.skipif(
    shutil.which("g++") is None, reason="compiling the sketches needs g++, which is not there"
)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    def compile_(name, *options):
        program = tmp_path_factory.mktemp(name) / name
        sketch = FIRMWARE / name / f"{name}.ino"
        words = ["g++", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unused-const-variable"]
        subprocess.run(
            [
                *words,
                *options,
                "-include",
                str(HERE / "arduino.h"),
                "-x",
                "c++",
                str(sketch),
                "-o",
                str(program),
            ],
            check=True,
        )
        return program

    return compile_


@contextmanager
def running(program):
    """The sketch at one end of a pseudo-terminal; the other end's name."""
    master, slave = os.openpty()
    tty.setraw(slave)
    child = subprocess.Popen([program], stdin=master, stdout=master)
    try:
        yield os.ttyname(slave)
    finally:
        child.kill()
        child.wait()
        os.close(master)
        os.close(slave)


def test_the_sketch_of_frames(compiled, tmp_path):
    with running(compiled("rig_frames")) as port:
        done = record(Port(port, 460800), tmp_path / "run.csv", Settings(2.0, omega=13.09))
        again = record(Port(port, 460800), tmp_path / "decay.csv", Settings(0.5, release=0.4))
        other = Settings(0.5, omega=13.09, amplitude=0.3)  # its crank makes 0.18
        with pytest.raises(InputError, match="cannot do this value"):
            record(Port(port, 460800), tmp_path / "other.csv", other)
    values = read_columns(done.path).values
    t = values["t"]
    samples = done.metadata["samples"]
    assert samples["written"] + samples["lost"] == 2001  # the clock wrapped in between
    np.testing.assert_array_equal(t, np.rint(t * 1000) / 1000)
    assert samples["lost"] <= 5
    # nominal calibration: gain 2.64 for 2.6 V/rad in both bridges, which cancels
    assert np.ptp(values["phi1"]) == pytest.approx(0.8, abs=0.03)
    assert np.ptp(values["phi2"]) == pytest.approx(0.6, abs=0.03)
    # the frequency that the timer can do is what is written down
    assert done.omega == pytest.approx(13.09, rel=1e-4)
    assert done.metadata["device"]["name"] == "torsion pendulum, rig_frames 1"
    assert done.metadata["calibration"]["source"].startswith("nominal")
    assert again.metadata["device"]["boot"] == done.metadata["device"]["boot"]
    assert again.rows + again.metadata["samples"]["lost"] == 501
    assert not again.forced


def test_the_sketch_of_text(compiled, tmp_path):
    assert len((FIRMWARE / "rig_text" / "rig_text.ino").read_text().splitlines()) <= 14
    with running(compiled("rig_text", "-DTEXT", "-DPOWERED_FOR=0.0")) as port:
        done = record(Port(port, 460800), tmp_path / "run.csv", Settings(2.0))
    values = read_columns(done.path).values
    assert done.metadata["stream"] == "text"
    t, phi1 = values["t"], values["phi1"]
    assert t.size == pytest.approx(501, abs=3)
    assert np.median(np.diff(t)) == pytest.approx(0.004, abs=2e-4)
    assert np.ptp(phi1) == pytest.approx(0.8, abs=0.02)
    # a time is that of its reading, also where this computer was busy in between
    moves = np.stack([np.sin(9.0 * t), np.cos(9.0 * t)], axis=1)
    left = phi1 - moves @ np.linalg.lstsq(moves, phi1)[0]
    assert np.median(np.abs(left)) < 2e-3
    assert np.mean(np.abs(left) > 4e-3) < 0.1
