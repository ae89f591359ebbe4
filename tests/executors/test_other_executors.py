"""The same pieces through Ray, Dask and submitit, with workers killed meanwhile: equal results."""

import subprocess
import sys
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from scripts._executors import Hand, begun_times
from tests.executors.stand_in import some_pieces, summed
from tp_jax.errors import InputError, Notice
from tp_jax.executors import ExecutorChoice, ray_actors, run_pieces, slurm_jobs
from tp_jax.executors.workers import Refused

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


def test_a_scheduler_that_does_not_answer_is_named(monkeypatch):
    pytest.importorskip("distributed", reason="needs the extra `dask`")
    import dask.config

    timeout = {"distributed.comm.timeouts.connect": "0.5s"}
    with (
        dask.config.set({"scheduler-address": "tcp://127.0.0.1:1", **timeout}),
        pytest.raises(InputError, match=r"answers at tcp://127\.0\.0\.1:1, which DASK_SCHED"),
        ExecutorChoice("dask", 1).opened(),
    ):
        pass


def test_actors_are_no_more_than_a_cluster_has_room_for():
    ray = SimpleNamespace(available_resources=lambda: {"CPU": 2.0, "memory": 1e9})
    assert ray_actors._placed(ray, 2) == 2
    with pytest.warns(Notice, match="2 processors free"):
        assert ray_actors._placed(ray, 3) == 2
    with pytest.raises(InputError, match="no processor free"):
        ray_actors._placed(SimpleNamespace(available_resources=dict), 1)


class Limited(Executor):
    """A cluster that takes so many jobs at once, and refuses more, as Slurm does."""

    def __init__(self, most):
        self.most, self.pool, self.futures = most, ThreadPoolExecutor(2), []

    def submit(self, fn, /, *args, **kwargs):
        if sum(not each.done() for each in self.futures) >= self.most:
            raise Refused("sbatch: error: QOSMaxSubmitJobPerUserLimit")
        self.futures.append(self.pool.submit(fn, *args, **kwargs))
        return self.futures[-1]


@pytest.mark.parametrize("most", [0, 1])
def test_a_refused_job_waits_for_those_in_hand(most, tmp_path, monkeypatch):
    pieces = some_pieces(3, tmp_path / "begun")
    monkeypatch.setattr(slurm_jobs, "opened", lambda *_: nullcontext(Limited(most)))
    done = run_pieces(summed, pieces, ExecutorChoice("slurm", 3), uses_jax=False)
    if most:
        assert {each.piece.key for each in done} == {each.key for each in pieces}
    else:
        with pytest.raises(InputError, match="takes no work: sbatch: error: QOSMax"):
            list(done)


def test_their_packages_load_only_where_they_are_asked_for():
    code = "import sys, tp_jax.executors; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert loaded.isdisjoint({*PACKAGES.values(), "dask", "jax", "numpy"})
