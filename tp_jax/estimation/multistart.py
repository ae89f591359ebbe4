"""A search from many starts.

Each start is fitted to a few short windows first. Starts that have met there go on as one: from
the same point the same method ends in the same place. What is far worse than the best by then is
left behind, and reported so.
"""

import dataclasses
import logging
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from tp_jax.estimation.checkpoint import Checkpoint
from tp_jax.estimation.layout import Values
from tp_jax.estimation.optima import groups
from tp_jax.estimation.outcome import Outcome
from tp_jax.estimation.schedule import Schedule
from tp_jax.estimation.starts import Start

log = logging.getLogger(__name__)

BATCH = 4  # starts between two writings of the file
WORKERS = 2  # fits side by side: those of few windows leave a core idle
BEHIND = 0.5  # of the best sum of squares: what is so much worse after the first rung stays there

Progress = Callable[[str, float | None], None]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a search; what is done is kept where there is a checkpoint."""

    def __init__(self, done: int, total: int, kept: str | None):
        self.done, self.total, self.kept = done, total, kept
        text = f"Interrupted after {done} of {total} starts"
        super().__init__(
            f"{text}, which are lost."
            if kept is None
            else f"{text}, which are kept in {kept}; the same command with --resume goes on."
        )


@dataclasses.dataclass(frozen=True)
class Trial:
    """One start and what became of it.

    start: where it began; near: after the first rung; end: at the last, that of the start it met
    if any; met: that start, itself otherwise; alone: evaluations it would have taken by itself.
    """

    start: Start
    near: Outcome
    end: Outcome
    met: int
    alone: int

    def record(self, i: int) -> dict[str, Any]:
        """Returns the trial for identify's JSON."""
        joined = self.met != i
        spent = self.near.evaluations if joined else self.alone
        message = f"Met start {self.met + 1} in short windows." if joined else self.end.message
        return {
            "objective": self.end.objective if np.isfinite(self.end.objective) else None,
            "converged": bool(self.end.converged),
            "evaluations": int(spent),
            "message": message,
        }


def search(
    starts: Sequence[Start],
    schedule: Schedule,
    *,
    checkpoint: Checkpoint | None = None,
    progress: Progress,
) -> list[Trial]:
    """Fits from every start.

    Args:
        starts: where to begin.
        schedule: the horizons of the campaign, and the method that fits at each.
        checkpoint: what is done already, and where to keep what will be.
        progress: called with a stage's name and the part of it that is done.

    Raises:
        Interrupted: by Ctrl-C.
    """
    done: dict[str, Any] = {} if checkpoint is None else dict(checkpoint.done)

    def keep(results: dict[str, Outcome]) -> None:
        stored = {name: o.to_dict() for name, o in results.items()}
        done.update(stored)
        if checkpoint is not None:
            checkpoint.put(stored)

    n, unknowns = len(starts), schedule.setting.unknowns()
    try:
        todo = [i for i in range(n) if f"start {i}" not in done]
        for batch in (todo[i : i + BATCH] for i in range(0, len(todo), BATCH)):
            progress(f"starts, {n} in all", (n - len(todo) + todo.index(batch[0])) / n)
            with ThreadPoolExecutor(WORKERS) as pool:
                found = list(pool.map(lambda i: _near(schedule, starts[i].values), batch))
            keep({f"start {i}": o for i, o in zip(batch, found, strict=True)})
        near = [Outcome.from_dict(done[f"start {i}"]) for i in range(n)]
        coordinates = [schedule.coordinates(o.x) for o in near]
        stands = groups(near, coordinates)
        leaders = sorted(set(stands), key=lambda i: (near[i].cost, i))
        best = near[leaders[0]].cost

        def end(i: int) -> Outcome:
            values = near[i].values(starts[i].values, unknowns)
            left = near[i].cost > (1.0 + BEHIND) * best
            return _end(schedule, near[i], values, left=left)

        todo = [i for i in leaders if f"end {i}" not in done]
        for batch in (todo[i : i + WORKERS] for i in range(0, len(todo), WORKERS)):
            part = len(leaders) - len(todo) + todo.index(batch[0])
            progress(f"optima, {len(leaders)} in all", part / len(leaders))
            with ThreadPoolExecutor(WORKERS) as pool:
                found = list(pool.map(end, batch))
            keep({f"end {i}": o for i, o in zip(batch, found, strict=True)})
        ends = {i: Outcome.from_dict(done[f"end {i}"]) for i in leaders}
    except KeyboardInterrupt:
        finished = sum(f"start {i}" in done for i in range(n))
        kept = None if checkpoint is None else str(checkpoint.path)
        raise Interrupted(finished, n, kept) from None
    return [
        Trial(s, o, ends[j], j, o.evaluations + ends[j].evaluations)
        for s, o, j in zip(starts, near, stands, strict=True)
    ]


def _near(schedule: Schedule, values: Values) -> Outcome:
    try:
        return Outcome.of(schedule.first(values))
    except np.linalg.LinAlgError as fault:  # a start can be anything: that is an answer too
        log.info("a start failed: %s", fault)
        x = values.pick(schedule.setting.unknowns())
        return Outcome.failed(x, "The equations of a step could not be solved.")


def _end(schedule: Schedule, near: Outcome, values: Values, *, left: bool) -> Outcome:
    if not np.isfinite(near.cost):
        return dataclasses.replace(near, evaluations=0)
    if left:
        end = Outcome.of(schedule.as_it_is(values))
        message = "Left behind: in short windows its chi-square is far from the best start's."
        return dataclasses.replace(end, converged=False, message=message)
    return Outcome.of(schedule.run(values), keep_states=True)
