"""Rigs over all processors. Each result is a line of a file as soon as it is there, so that the
same call goes on where the last one was stopped."""

import json
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path
from typing import Any

from scripts._coverage.settings import Settings


def read(path: Path) -> dict[int, dict[str, Any]]:
    """Results by rig; a last line that was cut off does not count."""
    found: dict[int, dict[str, Any]] = {}
    if path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                entry = json.loads(line)
            except json.JSONDecodeError:
                continue
            found[entry["rig"]] = entry
    return found


def over_all_cores(
    path: Path,
    numbers: Sequence[int],
    settings: Settings,
    workers: int,
    until: float,
    progress: Callable[[str, float | None], None],
) -> dict[int, str]:
    """Studies rigs and appends their results to a file; none is begun after `until`.

    Returns:
        Rig -> its fault, of those that failed.
    """
    failed: dict[int, str] = {}
    queue, done = list(numbers)[::-1], 0
    if not queue:
        return failed
    mend(path)
    context = multiprocessing.get_context("spawn")
    processors = context.Queue()
    for i in range(workers):
        processors.put(i)
    with (
        ProcessPoolExecutor(workers, context, begin, (processors,)) as pool,
        path.open("a", encoding="utf-8") as file,
    ):
        running: dict[Future, int] = {}
        while queue or running:
            # no more in hand than run, or those in hand would begin after `until`
            while queue and len(running) < workers and time.monotonic() <= until:
                number = queue.pop()
                running[pool.submit(one, number, settings)] = number
            if not running:
                break
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                number = running.pop(future)
                fault = future.exception()
                if fault is None:
                    file.write(future.result() + "\n")
                    file.flush()
                else:
                    failed[number] = f"{type(fault).__name__}: {fault}"
                done += 1
                progress("rigs", done / len(numbers))
    return failed


def mend(path: Path) -> None:
    """A line that was cut off gets an end, so that the next one does not join it."""
    if path.is_file() and path.stat().st_size:
        with path.open("rb+") as file:
            file.seek(-1, os.SEEK_END)
            if file.read(1) != b"\n":
                file.write(b"\n")


def begin(processors: Any) -> None:
    """A worker: on one processor, which JAX then takes for the whole machine."""
    mine = processors.get()
    if hasattr(os, "sched_setaffinity"):
        allowed = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {allowed[mine % len(allowed)]})
    from tp_jax._config import compile_small_loops, enable_compilation_cache, use_float64

    compile_small_loops()
    use_float64()
    enable_compilation_cache()


def one(number: int, settings: Settings) -> str:
    """One rig's result as a line of JSON."""
    from scripts._coverage.rig import study
    from tp_jax.cli.output import plain

    return json.dumps(plain(study(number, settings)), allow_nan=False)


def told(failed: dict[int, str]) -> None:
    """Faults, on standard error."""
    for number, fault in failed.items():
        print(f"coverage: rig {number} failed: {fault}", file=sys.stderr)
