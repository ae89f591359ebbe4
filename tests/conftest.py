"""What all tests share."""

import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import settings

# as the command line does, and like it before equinox is imported
os.environ.setdefault("EQX_ON_ERROR", "nan")

from tp_jax._config import CACHED_ABOVE, compile_small_loops, use_float64

# What one process of a test run has compiled the others need not: its workers, notebooks' kernels
# and examples' interpreters inherit this. It is not the folder of the command line, beside which
# traced programs are kept: these tests trace what they test.
COMPILED = None
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    COMPILED = tempfile.mkdtemp(prefix="tp-jax-tests-")
    os.environ["JAX_COMPILATION_CACHE_DIR"] = COMPILED
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", str(CACHED_ABOVE))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "0")

compile_small_loops()
use_float64()

ROOT = Path(__file__).parent.parent

# the same examples in every run, and no fault for being slow on a busy machine
settings.register_profile("deterministic", derandomize=True, deadline=None, database=None)
settings.load_profile("deterministic")


def pytest_unconfigure() -> None:
    if COMPILED is not None:  # in the process that made it, so after its workers
        shutil.rmtree(COMPILED, ignore_errors=True)


@pytest.fixture(scope="session")
def shared() -> Path:
    """Data that lies beside the repository rather than in it."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("needs the folder `shared` beside the repository, which is not there")
    return folder
