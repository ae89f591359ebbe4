"""Shows what a long computation is at, on standard error, in one of several forms.

The library knows nothing of terminals. It calls `progress(stage, part)`: a stage in words and how
much of it is done, from 0 to 1, or None where that is not known. A stage may add after a colon what
it is at ("refitting: drive_delay"); the part, and the time left, are of what stands before it.
"""

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from io import TextIOBase
from typing import TextIO

from tp_jax import _compiling

Progress = Callable[[str, float | None], None]

FORMS = ("auto", "plain", "json", "none")
"""auto: bars on a terminal, nothing elsewhere; plain: lines of text; json: an object a line."""


@dataclass(frozen=True)
class Pace:
    """Pace at which lines are written, and from when on the time left is reported.

    Attributes:
        plain_s: seconds between two lines of text, at least: a log is to stay readable.
        json_s: seconds between two objects of one stage, at least; a new one is reported at once.
        known_s: seconds of a stage from which on its speed says how long the rest takes.
    """

    plain_s: float = 10.0
    json_s: float = 0.5
    known_s: float = 1.0


PACE = Pace()


@dataclass(frozen=True)
class State:
    """State of a computation.

    Attributes:
        stage: in words. part: of the stage, from 0 to 1, or None where that is not known.
        elapsed_s: seconds since the computation began. left_s: of the stage, or None.
    """

    stage: str
    part: float | None
    elapsed_s: float
    left_s: float | None

    def to_json(self) -> str:
        """One object, on one line."""
        left = None if self.left_s is None else round(self.left_s, 1)
        part = None if self.part is None else round(self.part, 4)
        told = {"stage": self.stage, "part": part, "elapsed_s": round(self.elapsed_s, 1)}
        return json.dumps({**told, "left_s": left}, ensure_ascii=False)

    def to_text(self) -> str:
        """`0:42  refitting: drive_delay, 50 %, 0:12 left`"""
        part = "" if self.part is None else f", {100.0 * self.part:.0f} %"
        left = "" if self.left_s is None else f", {clock(self.left_s)} left"
        return f"{clock(self.elapsed_s)}  {self.stage}{part}{left}"


class Watch:
    """Times the stages of one computation."""

    def __init__(self, now: Callable[[], float] = time.monotonic, pace: Pace = PACE):
        self._now, self._pace = now, pace
        self._begin = now()
        self._name, self._since, self._first = "", self._begin, 0.0

    def at(self, stage: str, part: float | None) -> State:
        """The state as the library tells it now."""
        now, name = self._now(), stage.partition(":")[0]
        part = None if part is None else min(max(float(part), 0.0), 1.0)
        if name != self._name or (part or 0.0) < self._first:
            self._name, self._since, self._first = name, now, part or 0.0
        return State(stage, part, now - self._begin, self._left(now - self._since, part))

    def _left(self, took: float, part: float | None) -> float | None:
        """Seconds left of a stage; what was done when it began (resumed, say) took no time."""
        if part is None or part <= self._first or took < self._pace.known_s:
            return None
        return took * (1.0 - part) / (part - self._first)


def clock(seconds: float) -> str:
    """`0:07`, `12:30`, `1:02:03`"""
    minutes, s = divmod(round(seconds), 60)
    hours, m = divmod(minutes, 60)
    return f"{hours}:{m:02d}:{s:02d}" if hours else f"{m}:{s:02d}"


def silent(stage: str, fraction: float | None = None) -> None:
    """Shows nothing."""


@contextmanager
def shown(*, quiet: bool, form: str = "auto") -> Iterator[Progress]:
    """A `progress` to hand to the library; what bars show is gone when the block ends.

    Args:
        quiet: shows nothing, unless another form than "auto" is asked for.
        form: one of `FORMS`.
    """
    if form == "json":
        yield _lines(sys.stderr, State.to_json, PACE.json_s, each_stage=True)
    elif form == "plain":
        yield _lines(sys.stderr, State.to_text, PACE.plain_s, each_stage=False)
    elif form == "none" or quiet or not sys.stderr.isatty():
        yield silent
    else:
        with _bars() as progress:
            yield progress


def _lines(
    stream: TextIO | TextIOBase,
    written: Callable[[State], str],
    every_s: float,
    *,
    each_stage: bool,
) -> Progress:
    """Writes a line at most every so many seconds; at once for a new stage, where that is asked."""
    watch, last = Watch(), (-every_s, "")

    def report(stage: str, part: float | None = None) -> None:
        nonlocal last
        state = watch.at(stage, part)
        if state.elapsed_s - last[0] >= every_s or (each_stage and stage != last[1]):
            last = state.elapsed_s, stage
            with suppress(OSError, ValueError):  # nobody reads any more: no reason to end the work
                stream.write(f"{written(state)}\n")
                stream.flush()

    return report


@contextmanager
def _bars() -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        ProgressColumn,
        SpinnerColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
    )
    from rich.progress import Progress as Bars
    from rich.text import Text

    class CompilingColumn(ProgressColumn):
        """Column that says why nothing seems to happen on a first run."""

        max_refresh = 0.5

        def render(self, task: Task) -> Text:  # noqa: ARG002
            return Text(_compiling.described())

    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        CompilingColumn(),
    )
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
        watch, bar = Watch(), bars.add_task("", total=None, left="")

        def report(stage: str, part: float | None = None) -> None:
            state = watch.at(stage, part)
            left = "" if state.left_s is None else f"{clock(state.left_s)} left"
            total = None if state.part is None else 1.0
            bars.update(bar, description=stage, total=total, completed=state.part or 0.0, left=left)

        yield report
