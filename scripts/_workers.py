"""Tasks of a study over all processors, each in a process that has one of them."""

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any


def over_all_cores(
    work: Callable[..., Any],
    tasks: Sequence[tuple],
    workers: int,
    until: float,
    *,
    last: int | None = None,
) -> Iterator[tuple[tuple, Future]]:
    """Tasks as they end, with the future that has their result or fault.

    Args:
        work: of a task's members; it and they travel to another process.
        tasks: in this order.
        workers: processes.
        until: on `time.monotonic`; no task is begun after it.
        last: tasks of a process, after which another takes its place: what it compiled adds up.
    """
    context = multiprocessing.get_context("spawn")
    queue = list(tasks)[::-1]
    while queue and time.monotonic() <= until:
        left = len(queue) if last is None else min(workers * last, len(queue))
        processors = context.Queue()
        for i in range(workers):
            processors.put(i)
        with ProcessPoolExecutor(workers, context, _begin, (processors,)) as pool:
            running: dict[Future, tuple] = {}
            while left or running:
                # no more in hand than run, or those in hand would begin after `until`
                while left and len(running) < workers and time.monotonic() <= until:
                    task = queue.pop()
                    left -= 1
                    running[pool.submit(work, *task)] = task
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future


def fault_of(future: Future) -> str | None:
    """What went wrong in a task, in a line; None if nothing did."""
    fault = future.exception()
    return None if fault is None else f"{type(fault).__name__}: {fault}"


def _begin(processors: Any) -> None:
    """A worker: on one processor, which JAX then takes for the whole machine."""
    mine = processors.get()
    if hasattr(os, "sched_setaffinity"):
        allowed = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {allowed[mine % len(allowed)]})
    from tp_jax._config import compile_small_loops, enable_compilation_cache, use_float64

    compile_small_loops()
    use_float64()
    enable_compilation_cache()
