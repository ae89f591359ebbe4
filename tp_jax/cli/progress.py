"""Shows what a long computation is at: on standard error, on a terminal, and only there.

Another program that runs a command asks for lines instead (`--progress-lines`).

The library knows nothing of terminals. It calls `progress(stage, fraction)`: a stage in words and
how much of it is done, from 0 to 1, or None where that is not known.
"""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[str, float | None], None]


def silent(stage: str, fraction: float | None = None) -> None:
    """Shows nothing."""


def as_line(stage: str, fraction: float | None = None) -> None:
    """Writes a stage and its part as a line of JSON on standard error."""
    line = json.dumps({"stage": stage, "part": fraction}, ensure_ascii=True)
    print(line, file=sys.stderr, flush=True)


@contextmanager
def shown(*, quiet: bool, lines: bool = False) -> Iterator[Progress]:
    """A `progress` to hand to the library; what it shows is gone when the block ends.

    Args:
        quiet: show nothing.
        lines: write lines for a program to read, terminal or not.
    """
    if lines:
        yield as_line
        return
    if quiet or not sys.stderr.isatty():
        yield silent
        return

    from rich.console import Console
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
        stages: dict = {}

        def report(stage: str, fraction: float | None = None) -> None:
            if stage not in stages:
                for done in stages.values():
                    bars.update(done, visible=False)
                stages[stage] = bars.add_task(stage, total=None)
            if fraction is not None:
                bars.update(stages[stage], total=1.0, completed=fraction, visible=True)

        yield report
