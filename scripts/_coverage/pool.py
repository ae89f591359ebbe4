"""Rigs over all processors. Each result is a line of a file as soon as it is there, so that the
same call goes on where the last one was stopped."""

import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from scripts._coverage.settings import Settings
from tp_jax.executors import ExecutorChoice, Piece, run_pieces


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


def studied(
    path: Path,
    numbers: Sequence[int],
    settings: Settings,
    executor: ExecutorChoice,
    until: float,
    progress: Callable[[str, float | None], None],
) -> dict[int, str]:
    """Studies rigs and appends their results to a file; none is begun after `until`.

    Returns:
        Rig -> its fault, of those that failed.
    """
    failed: dict[int, str] = {}
    if not numbers:
        return failed
    mend(path)
    pieces = [Piece(f"rig-{number}", (number, settings)) for number in numbers]
    with path.open("a", encoding="utf-8") as file:
        for done, ended in enumerate(run_pieces(one, pieces, executor, until=until), start=1):
            if ended.fault is None:
                file.write(ended.result + "\n")
                file.flush()
            else:
                failed[ended.piece.arguments[0]] = str(ended.fault)
            progress("rigs", done / len(numbers))
    return failed


def mend(path: Path) -> None:
    """A line that was cut off gets an end, so that the next one does not join it."""
    if path.is_file() and path.stat().st_size:
        with path.open("rb+") as file:
            file.seek(-1, os.SEEK_END)
            if file.read(1) != b"\n":
                file.write(b"\n")


def one(number: int, settings: Settings) -> str:
    """One rig's result as a line of JSON."""
    from scripts._coverage.rig import study
    from tp_jax.cli.output import plain

    return json.dumps(plain(study(number, settings)), allow_nan=False)


def told(failed: dict[int, str]) -> None:
    """Faults, on standard error."""
    for number, fault in failed.items():
        print(f"coverage: rig {number} failed: {fault}", file=sys.stderr)
