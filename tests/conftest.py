"""What all tests share."""

import gc
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import settings

# as the command line does, and like it before equinox is imported
os.environ.setdefault("EQX_ON_ERROR", "nan")

# Linear algebra in one thread, as in a diagnosis (see tp_jax._blas), in all processes that tests
# start. Tests call a diagnosis' parts alone, and threads of two workers would spin on two cores:
# `free_structure` took eight times the CPU time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tp_jax import _blas, _cache
from tp_jax._config import cache_folder, collect_less, compile_small_loops

# What one process of a test run has traced and compiled the others need not: its workers,
# notebooks' kernels and examples' interpreters inherit this. It is a folder of this run alone, so
# that all programs in it are those of the source that is tested.
CACHE = None
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    CACHE = tempfile.mkdtemp(prefix="tp-jax-tests-")
    os.environ["XDG_CACHE_HOME"] = CACHE
    _cache.made(cache_folder())
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(cache_folder())
    # small programs too: tests compile tens of thousands, and to load one takes a fifth of that
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES", "0")

# Nor need two processes find the same diagnosis (see tests/kept.py); one of an earlier run, and of
# another source, is never taken.
KEPT = None
if "TP_JAX_TESTS_KEPT" not in os.environ:
    KEPT = os.environ["TP_JAX_TESTS_KEPT"] = tempfile.mkdtemp(prefix="tp-jax-tests-")

compile_small_loops()

import tp_jax._float64  # noqa: E402, F401  # loads JAX: after its settings

collect_less()  # as the command line does
_blas.threadpool_limits(limits=1, user_api="blas")  # this process: numpy is loaded already

ROOT = Path(__file__).parent.parent

# the same examples in every run, and no fault for being slow on a busy machine
settings.register_profile("deterministic", derandomize=True, deadline=None, database=None)
settings.load_profile("deterministic")


MOST_MAPPED = 30_000
"""Pieces of memory of a process, of which Linux allows 65,530: beyond, what is compiled cannot be
placed, and the process ends at once. A test run compiles tens of thousands of small programs."""

MOST_RESIDENT = 4_000_000_000
"""Bytes of memory of a process: two of nine gigabytes, as they were, leave a machine little."""


@pytest.fixture(scope="module", autouse=True)
def room_for_programs():
    """Compiled programs are dropped when many are there; what is kept on disk is loaded again."""
    yield
    maps, pages = Path("/proc/self/maps"), Path("/proc/self/statm")
    if not maps.is_file() or "jax" not in sys.modules:
        return
    resident = int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    if maps.read_bytes().count(b"\n") > MOST_MAPPED or resident > MOST_RESIDENT:
        import jax

        from tp_jax import _memory, _stored

        for each in gc.get_objects():
            if type(each) is _stored.Stored:
                each._ready.clear()
        jax.clear_caches()
        gc.collect()
        _memory.release()


def pytest_unconfigure() -> None:
    for folder in (CACHE, KEPT):
        if folder is not None:  # in the process that made it, so after its workers
            shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def shared() -> Path:
    """Data that lies beside the repository rather than in it."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("needs the folder `shared` beside the repository, which is not there")
    return folder
