"""The simulator shares nothing with the model that is put to the test on it."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RIG = ROOT / "tp_jax" / "rig"
HIDDEN = ROOT / "trials" / "effects"
#: Speaking the wire's language is another matter than moving like a pendulum.
WIRE = {"emulator.py", "serve.py"}
FILES = sorted(f for d in (RIG, HIDDEN) for f in d.rglob("*.py") if f.name not in WIRE)
MAY = {"tp_jax.errors", "tp_jax.recordings", "tp_jax.rig", "trials.effects", "numpy", "scipy"}


def imported(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level
            names.add(node.module or "")
    return names


@pytest.mark.parametrize("file", FILES, ids=lambda f: str(f.relative_to(ROOT)))
def test_imports(file):
    for name in imported(file):
        own = ".".join(name.split(".")[: 2 if name.startswith(("tp_jax", "trials")) else 1])
        assert own in MAY or own in sys.stdlib_module_names, name


def test_smooths_no_friction():
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        assert "arctan(" not in text.replace("arctan2(", "")
        assert "atan(" not in text
        # an amplifier's compression is no friction
        assert "tanh(" not in text or file.name == "cousins_sensors.py"


def test_loads_without_jax_and_the_model():
    program = "import sys, tp_jax.rig; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    loaded = set(done.stdout.split())
    assert not loaded & {"jax", "diffrax", "equinox", "optimistix", "numba", "matplotlib"}
    parts = ("model", "effects", "simulation", "estimation", "gap")
    assert not loaded & {f"tp_jax.{part}" for part in parts}
