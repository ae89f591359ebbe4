"""The same pieces through Ray, Dask and submitit, with workers killed meanwhile: equal results."""

import subprocess
import sys

import pytest

from scripts._executors import Hand, begun_times
from tests.executors.stand_in import some_pieces, summed
from tp_jax.errors import InputError
from tp_jax.executors import ExecutorChoice, run_pieces, slurm_jobs

PACKAGES = {"ray": "ray", "dask": "distributed", "slurm": "submitit"}
COUNT = 8


@pytest.fixture(autouse=True)
def _no_cluster(monkeypatch):
    """submitit's own executor in the place of Slurm; Ray and Dask start workers here."""
    monkeypatch.setattr(slurm_jobs, "CLUSTER", "local")
    for name in ("RAY_ADDRESS", "DASK_SCHEDULER_ADDRESS"):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("kind", list(PACKAGES))
def test_killed_workers_lose_nothing(kind, tmp_path):
    pytest.importorskip(PACKAGES[kind], reason=f"needs the extra `{kind}`")
    pieces = some_pieces(COUNT, tmp_path / "begun")
    choice = ExecutorChoice(kind, 2)
    with Hand(tmp_path / "begun", times=0 if kind == "slurm" else 2, every_s=0.2) as hand:
        ended = list(run_pieces(summed, pieces, choice, folder=tmp_path, uses_jax=False))
    assert len(hand.killed) == (0 if kind == "slurm" else 2)
    assert sorted(each.piece.key for each in ended) == sorted(each.key for each in pieces)
    before = begun_times(tmp_path / "begun")
    for each in ended:
        assert each.fault is None
        assert each.result == summed(each.piece.arguments[0], tmp_path / "begun")
    assert sum(before.values()) <= COUNT + 2 * len(hand.killed)
    # and what is done is not done again, whatever the executor
    again = list(run_pieces(summed, pieces, ExecutorChoice("local", 1), folder=tmp_path))
    assert all(each.kept for each in again)


@pytest.mark.parametrize("kind", list(PACKAGES))
def test_a_missing_package_is_said_with_its_command(kind, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, PACKAGES[kind], None)
    pieces = some_pieces(1, tmp_path / "begun")
    with pytest.raises(InputError) as told:
        list(run_pieces(summed, pieces, ExecutorChoice(kind, 1)))
    said = str(told.value)
    assert f"pip install 'tp-jax[{kind}]'" in said
    assert said.count(". ") == 0, "one sentence"


def test_without_slurm_that_is_said(tmp_path, monkeypatch):
    pytest.importorskip("submitit", reason="needs the extra `slurm`")
    monkeypatch.setattr(slurm_jobs, "CLUSTER", "slurm")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="`srun` and `sbatch`"):
        list(run_pieces(summed, some_pieces(1, tmp_path / "begun"), ExecutorChoice("slurm", 1)))


def test_their_packages_load_only_where_they_are_asked_for():
    code = "import sys, tp_jax.executors; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert loaded.isdisjoint({*PACKAGES.values(), "dask", "jax", "numpy"})
