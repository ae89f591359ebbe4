"""The subpackage stands on NumPy alone, and on schemas, so that recording does not wait for JAX."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOREIGN = {"jax", "jsonschema", "scipy", "diffrax", "equinox", "optimistix", "matplotlib"}


def test_imports():
    others = {
        f"tp_jax.{each.name}"
        for each in (ROOT / "tp_jax").iterdir()
        if each.is_dir() and each.name not in ("recordings", "schemas")
    }
    program = "import sys, tp_jax.recordings; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert not set(done.stdout.split()) & (FOREIGN | others)
