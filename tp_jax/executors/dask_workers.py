"""Dask's own executor: of the scheduler that is configured, or of workers on this machine."""

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from tp_jax.errors import InputError
from tp_jax.executors.missing import missing


@contextmanager
def opened(workers: int) -> Iterator[Executor]:
    """The executor of a client.

    Args:
        workers: processes of one thread, where no `DASK_SCHEDULER_ADDRESS` names a scheduler.

    Raises:
        InputError: Dask is not installed, or the scheduler does not answer.
    """
    try:
        import dask.config
        import distributed
    except ImportError as fault:
        raise missing("dask", "distributed") from fault
    address = dask.config.get("scheduler-address", None)
    if address is not None:
        try:
            client = distributed.Client(address)
        except OSError as fault:
            raise InputError(
                f"No scheduler of Dask answers at {address}, which DASK_SCHEDULER_ADDRESS names; "
                "start it, or unset the variable to use this machine."
            ) from fault
        with client:
            yield client.get_executor(pure=False)
        return
    # no page, no limit at which workers are paused, no word of each that is lost: the seam counts
    settings: dict[str, Any] = {
        "memory_limit": 0,
        "dashboard_address": None,
        "silence_logs": logging.ERROR,
    }
    cluster = distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, **settings
    )
    with cluster, distributed.Client(cluster) as client:
        yield client.get_executor(pure=False)
