"""Choice of an executor, and of how many pieces it has in hand."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tp_jax.executors import dask_workers, local_processes, ray_actors, slurm_jobs
from tp_jax.executors.processors import available

KINDS = ("local", "ray", "dask", "slurm")


@dataclass(frozen=True)
class ExecutorChoice:
    """An executor, not opened yet.

    Attributes:
        kind: one of `KINDS`.
        workers: pieces in hand at once: processes here, actors, workers or jobs elsewhere.
    """

    kind: str = "local"
    workers: int = field(default_factory=available)

    @contextmanager
    def opened(
        self, folder: Path | None = None, pieces_per_worker: int | None = None
    ) -> Iterator[Executor]:
        """The executor; work in hand is given up where the block ends by an exception.

        Args:
            folder: of the study, in which jobs of Slurm leave their logs.
            pieces_per_worker: see `run_pieces`.

        Raises:
            InputError: its package is not installed, or there is no cluster.
        """
        if self.kind == "local":
            opened = local_processes.opened(self.workers, pieces_per_worker)
        elif self.kind == "ray":
            opened = ray_actors.opened(self.workers, pieces_per_worker)
        elif self.kind == "dask":
            opened = dask_workers.opened(self.workers)
        elif self.kind == "slurm":
            opened = slurm_jobs.opened(self.workers, folder)
        else:
            raise ValueError(f"There is no executor {self.kind!r}; choose one of {KINDS}.")
        with opened as executor:
            yield executor
