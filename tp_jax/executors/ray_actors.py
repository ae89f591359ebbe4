"""Ray's actors as an executor: each keeps what it has compiled, on this machine or a cluster's.

Ray connects to the cluster that `RAY_ADDRESS` names, and starts one on this machine otherwise.
"""

import logging
import os
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

from tp_jax.errors import InputError, Notice
from tp_jax.executors.missing import missing
from tp_jax.executors.workers import Workers

STORE = 100_000_000
"""Bytes of memory for objects that travel, where Ray starts here: pieces and results take
kilobytes, and Ray would reserve a third of the machine."""


@contextmanager
def opened(workers: int, pieces_per_worker: int | None = None) -> Iterator[Executor]:
    """Opens so many actors of one processor each.

    Raises:
        InputError: Ray is not installed, the cluster does not answer, or it is full.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # nothing is reported to anybody
    try:
        import ray
    except ImportError as fault:
        raise missing("ray", "ray") from fault
    ours = not ray.is_initialized()
    if ours:
        own = (
            {}
            if os.environ.get("RAY_ADDRESS")
            else {
                "num_cpus": workers,
                "include_dashboard": False,
                "object_store_memory": STORE,
            }
        )
        try:
            ray.init(log_to_driver=False, logging_level=logging.ERROR, **own)
        except ConnectionError as fault:
            raise InputError(
                f"No cluster of Ray answers at {os.environ.get('RAY_ADDRESS')}, which RAY_ADDRESS "
                "names; start it, or unset the variable to use this machine."
            ) from fault
    try:
        executor = Workers(lambda: RayActor(ray), _placed(ray, workers), pieces_per_worker)
        try:
            yield executor
        finally:
            executor.shutdown(cancel_futures=True)  # all that was wanted has ended
    finally:
        if ours:
            ray.shutdown()


def _placed(ray: Any, workers: int) -> int:
    """Number of workers that the cluster has room for: an actor too many would wait for ever."""
    free = int(ray.available_resources().get("CPU", 0.0))
    if free < 1:
        raise InputError(
            "The cluster of Ray has no processor free; wait for other work, or add a machine."
        )
    if free < workers:
        warnings.warn(
            f"The cluster of Ray has {free} processors free, so {free} workers are used.",
            Notice,
            stacklevel=2,
        )
    return min(workers, free)


class Caller:
    """Class that an actor is made of."""

    def call(self, work: Callable[..., Any], arguments: tuple) -> Any:
        return work(*arguments)


class RayActor:
    """A worker: one actor. Ray does not restart it; another takes its place."""

    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self._actor = ray.remote(num_cpus=1, max_restarts=0)(Caller).remote()

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future:
        return self._actor.call.remote(work, arguments).future()

    def lost(self, fault: BaseException) -> bool:
        failed = self._ray.exceptions
        return isinstance(fault, failed.RayError) and not isinstance(fault, failed.RayTaskError)

    def end(self, *, at_once: bool) -> None:  # noqa: ARG002
        self._ray.kill(self._actor)
