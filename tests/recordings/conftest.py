"""Small campaigns to be read, and to be spoilt."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tp_jax.recordings import Recording, write_csv

NOISE = 1e-3


def motion(n: int = 500, rate: float = 250.0, seed: int = 0) -> tuple[np.ndarray, ...]:
    """Times [s] and two noisy angles [rad] of a plausible run."""
    random = np.random.default_rng(seed)
    t = np.arange(n) / rate
    phi1 = 0.5 * np.sin(13.0 * t) + NOISE * random.standard_normal(n)
    phi2 = 0.3 * np.sin(13.0 * t - 0.4) + NOISE * random.standard_normal(n)
    return t, phi1, phi2


def csv(header: str | None, *columns: np.ndarray) -> str:
    rows = [",".join(repr(float(cell)) for cell in row) for row in zip(*columns, strict=True)]
    return "\n".join([*([] if header is None else [header]), *rows]) + "\n"


@pytest.fixture
def campaign_folder(tmp_path: Path) -> Path:
    """decay.csv, run-06.csv, run-13.csv and run-17.csv with their campaign.toml."""
    toml = ['name = "small"', "", "[rig]", "B1 = 1.2e-3", "sample_rate = 250.0"]
    for i, (file, omega) in enumerate(
        {"decay.csv": 0.0, "run-06.csv": 6.0, "run-13.csv": 13.09, "run-17.csv": 17.0}.items()
    ):
        write_csv(tmp_path / file, *motion(seed=i))
        forced = "true" if omega else "false"
        toml += ["", "[[recording]]", f'file = "{file}"', f"omega = {omega}", f"forced = {forced}"]
    (tmp_path / "campaign.toml").write_text("\n".join(toml) + "\n", encoding="utf-8")
    return tmp_path


@pytest.fixture
def recording() -> Callable[..., Recording]:
    """Makes a recording without a file; what is given overrides."""

    def make(**given) -> Recording:
        t, phi1, phi2 = motion()
        values = {
            "name": "run.csv",
            "file": Path("run.csv"),
            "t": t,
            "phi1": phi1,
            "phi2": phi2,
            "drive": None,
            "forced": True,
            "omega": 13.0,
            "span": None,
            "start": None,
            "repeat": None,
            "held_out": False,
            "sha256": "",
        } | given
        return Recording(**{"label": values["name"]} | values)

    return make


@pytest.fixture
def edit(campaign_folder: Path) -> Callable[[str, str, str], None]:
    """Replaces a text in a file of the campaign, the first time it appears."""

    def replace(file: str, old: str, new: str) -> None:
        path = campaign_folder / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    return replace


@pytest.fixture
def write_run(campaign_folder: Path) -> Callable[..., None]:
    """Writes a data file of the campaign from a header and columns."""

    def write(file: str, header: str | None, *columns: np.ndarray) -> None:
        (campaign_folder / file).write_text(csv(header, *columns), encoding="utf-8")

    return write


@pytest.fixture
def run_columns() -> tuple[np.ndarray, ...]:
    """t, phi1, phi2 of a run, to be spoilt."""
    return motion()
