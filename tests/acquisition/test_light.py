"""Recording does not wait: what importing it costs, and what it does without."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NAMES = (
    "Calibration",
    "ClockFit",
    "Port",
    "Recorded",
    "SensorCalibration",
    "Settings",
    "Status",
    "calibrate",
    "fit_calibration",
    "fit_clock",
    "read_calibration",
    "record",
    "write_calibration",
)
HEAVY = {"jax", "jsonschema", "scipy", "rich", "matplotlib", "equinox", "diffrax", "numba"}


def test_every_name_is_there():
    import tp_jax.acquisition as acquisition

    for name in NAMES:
        assert getattr(acquisition, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        acquisition.nothing  # noqa: B018


def _imported() -> set[str]:
    program = "import sys, tp_jax.acquisition.recorder, tp_jax.acquisition.campaign_entry; "
    done = subprocess.run(
        [sys.executable, "-c", program + "print(*sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    return set(done.stdout.split())


def test_recording_does_without():
    assert not {name.split(".")[0] for name in _imported()} & HEAVY


def test_the_recorder_imports_nothing_else_of_the_package():
    # seconds depend on the machine (scripts/acquisition measures them); what they are made of
    # does not
    ours = {name.split(".")[1] for name in _imported() if name.startswith("tp_jax.")}
    # of schemas, plain numbers and words; what reads by them comes with the first file
    assert ours <= {"_files", "_version", "acquisition", "errors", "recordings", "schemas"}
