"""Many starts of the paper's way, reported like those of any other search."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tp_jax.estimation.checkpoint import Checkpoint
from tp_jax.estimation.free_run_search import ITERATIONS, free_run_search
from tp_jax.estimation.layout import Values
from tp_jax.estimation.multistart import Interrupted, Progress, Trial
from tp_jax.estimation.outcome import Outcome
from tp_jax.estimation.schedule import Schedule
from tp_jax.estimation.starts import Start

BATCH = 64  # searches side by side, and between two writings of the file


def search_free_runs(
    starts: Sequence[Start],
    schedule: Schedule,
    *,
    checkpoint: Checkpoint | None,
    progress: Progress,
    max_iterations: int = ITERATIONS,
) -> list[Trial]:
    """Nelder-Mead on (17) from every start; what was found is then judged by the windows.

    Arguments, result and exceptions are those of `multistart.search`.
    """
    setting, n = schedule.setting, len(starts)
    eps = setting.sharpest  # a simplex has no derivatives that would mind
    done: dict[str, Any] = {} if checkpoint is None else dict(checkpoint.done)
    try:
        todo = [i for i in range(n) if f"end {i}" not in done]
        for batch in (todo[i : i + BATCH] for i in range(0, len(todo), BATCH)):
            begin = [starts[i].values.replace({"eps1": eps, "eps2": eps}) for i in batch]
            found = free_run_search(setting, begin, progress, max_iterations=max_iterations)
            stored = {
                f"end {i}": _outcome(schedule, *each).to_dict()
                for i, each in zip(batch, found, strict=True)
            }
            done |= stored
            if checkpoint is not None:
                checkpoint.put(stored)
    except KeyboardInterrupt:
        finished = sum(f"end {i}" in done for i in range(n))
        raise Interrupted(finished, n, checkpoint and str(checkpoint.path)) from None
    ends = [Outcome.from_dict(done[f"end {i}"]) for i in range(n)]
    return [Trial(s, o, o, i, o.evaluations) for i, (s, o) in enumerate(zip(starts, ends))]  # noqa: B905


def _outcome(
    schedule: Schedule, values: Values, y: float, evaluations: int, converged: bool, message: str
) -> Outcome:
    """Returns what the numbers found are worth, and how well they are known."""
    if not np.isfinite(y):
        x = values.pick(schedule.setting.unknowns())
        return Outcome.failed(x, "No free run from here could be integrated.")
    fit = schedule.as_it_is(values)
    fit.evaluations, fit.converged, fit.message = evaluations, converged, message
    return Outcome.of(fit, keep_states=True, objective=y)
