"""Jobs of a Slurm cluster, one for each piece, by submitit.

What the cluster asks for (partition, account, time, memory) is told to `sbatch` by its own
environment variables, `SBATCH_PARTITION` and so on, which go before what stands here.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tp_jax.errors import InputError
from tp_jax.executors.missing import missing
from tp_jax.executors.workers import Refused, ended

CLUSTER = "slurm"
"""Name of the cluster for submitit; its own `local` needs no cluster."""

MINUTES = 24 * 60
"""Minutes of a job at most: a diagnosis takes minutes, a large one hours."""

LOGS = "jobs"
"""Folder of the jobs' logs and pickles, in the folder of the study or here."""


@contextmanager
def opened(workers: int, folder: Path | None = None) -> Iterator[Executor]:
    """Jobs, so many at once.

    Args:
        workers: jobs in hand. folder: of the study; all machines must see it under this name.

    Raises:
        InputError: submitit is not installed, or there is no Slurm.
    """
    try:
        import submitit
    except ImportError as fault:
        raise missing("slurm", "submitit") from fault
    logs = (folder or Path()) / LOGS
    try:
        jobs = submitit.AutoExecutor(logs.absolute(), cluster=CLUSTER)
    except RuntimeError as fault:
        raise InputError(
            "The executor slurm needs Slurm's commands, which are not found on this machine; run "
            "it where `srun` and `sbatch` can be called."
        ) from fault
    jobs.update_parameters(name="tp-jax", timeout_min=MINUTES, cpus_per_task=1)
    with ended(SlurmJobs(jobs, workers)) as executor:
        yield executor


class SlurmJobs(Executor):
    """submitit's executor with futures of the standard library: a thread waits for each job."""

    def __init__(self, jobs: Any, workers: int) -> None:
        self._jobs, self._submitted = jobs, []
        self._waiting = ThreadPoolExecutor(workers, thread_name_prefix="tp-jax-job")

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        try:
            job = self._jobs.submit(fn, *args, **kwargs)
        except RuntimeError as fault:  # submitit's own is one
            raise Refused(" ".join(str(fault).split())) from fault
        self._submitted.append(job)
        return self._waiting.submit(job.result)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        if cancel_futures:
            for job in self._submitted:
                if not job.done():
                    job.cancel()
        self._waiting.shutdown(wait, cancel_futures=cancel_futures)
