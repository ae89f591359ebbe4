"""A page of a folder of its own, with a stand-in for diagnoses."""

import shutil
import sys
from pathlib import Path

import pytest

from tp_jax.cli.diagnose import EXAMPLE

pytest.importorskip("starlette", reason="needs the extra `serve`: pip install '.[serve]'")

STAND_IN = Path(__file__).parent / "stand_in.py"
TOKEN = "a-key"
RUNS = sorted(EXAMPLE.glob("*.csv"))


def standing_in(end: str = "done"):
    """Makes the command line of the stand-in."""

    def child(campaign: Path, out: Path) -> list[str]:
        return [sys.executable, str(STAND_IN), str(out), end]

    return child


def answers(B1: str = "", **omegas: str) -> dict:
    """As the page sends them: run-06 at an omega, all others as decays."""
    names = [file.name for file in RUNS]
    runs = {name: {"used": True, "kind": "decay", "omega": ""} for name in names}
    for name, omega in omegas.items():
        runs[f"{name.replace('_', '-')}.csv"] = {"used": True, "kind": "commanded", "omega": omega}
    return {"B1": B1, "runs": runs}


COMMANDED = {
    "run_06": "6",
    "run_10": "10",
    "run_13": "13.09",
    "run_17": "17",
    "run_22": "22",
}


@pytest.fixture
def folder(tmp_path) -> Path:
    """An empty folder to be served."""
    made = tmp_path / "my rig"
    made.mkdir()
    return made


@pytest.fixture
def filled(folder) -> Path:
    """The same with the example's recordings, and no campaign.toml."""
    for file in RUNS:
        shutil.copy(file, folder)
    return folder


@pytest.fixture
def client(folder):
    """Knows the key."""
    with opened(folder) as found:
        found.get(f"/?token={TOKEN}")
        yield found


def opened(folder, end: str = "done", **options):
    """A client of a page, that knows no key yet."""
    from starlette.testclient import TestClient

    from tp_jax.serve.app import create_app

    app = create_app(folder, TOKEN, child=standing_in(end), **options)
    return TestClient(app, base_url="http://127.0.0.1:8000")
