"""What all tests share."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# as the command line does, and like it before equinox is imported
os.environ.setdefault("EQX_ON_ERROR", "nan")

from tp_jax._config import compile_small_loops, use_float64

compile_small_loops()
use_float64()

ROOT = Path(__file__).parent.parent

# the same examples in every run, and no fault for being slow on a busy machine
settings.register_profile("deterministic", derandomize=True, deadline=None, database=None)
settings.load_profile("deterministic")


@pytest.fixture(scope="session")
def shared() -> Path:
    """Data that lies beside the repository rather than in it."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("needs the folder `shared` beside the repository, which is not there")
    return folder
