"""Jobs by two threads, of which the caller is one."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def by_two(run: Callable[[Job], Result], jobs: Sequence[Job]) -> list[Result]:
    """Applies `run` to each job, by this thread and one more; a single job needs none more."""
    if len(jobs) == 1:
        return [run(jobs[0])]
    waiting = deque(enumerate(jobs))
    done: dict[int, Result] = {}

    def work() -> None:
        while True:
            try:
                i, job = waiting.popleft()
            except IndexError:
                return
            done[i] = run(job)

    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(work)
        work()
    other.result()
    return [done[i] for i in range(len(jobs))]
