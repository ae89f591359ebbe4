"""From the serial line to the cause: the README's second example, through the real commands."""

import json
import subprocess
import sys

import pytest

RUNS = [["--omega", w] for w in ("6", "10", "13.09", "17", "22")] + [["--release", "0.6"]]


def tp_jax(*args, cwd):
    done = subprocess.run(
        [sys.executable, "-m", "tp_jax", "--quiet", *args],
        cwd=cwd, capture_output=True, text=True, check=False, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_hidden_effect_is_recorded_and_found(tmp_path):
    for run in RUNS:
        tp_jax(
            "record", "--port", "emulator", "--duration", "10", "--rate", "250", *run,
            "--campaign", "my-rig", "--effect", "contact_stribeck=0.5", "--speed", "max",
            cwd=tmp_path,
        )  # fmt: skip
    assert len(list((tmp_path / "my-rig").glob("*.csv"))) == len(RUNS)
    found = json.loads(tp_jax("diagnose", "my-rig", "--json", "-", cwd=tmp_path))
    assert found["verdict"] == "explained"
    assert [cause["effect"] for cause in found["causes"]] == ["contact_stribeck"]
    assert found["causes"][0]["parameters"]["a"]["value"] == pytest.approx(0.5, rel=0.1)
    assert found["where"][0]["location"] == "contact"
    assert found["gap"]["shrink"] > 0.95
