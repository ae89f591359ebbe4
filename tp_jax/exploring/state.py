"""State of an exploration between two runs: explore.json beside the recordings.

The file is replaced at once and whole. It is written before a run is recorded, with the run and its
file, and after every diagnosis. So a program that is killed has lost the run it was recording, or
the diagnosis it was making, and nothing else: campaign.toml says which recordings there are.
"""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import write_json
from tp_jax.errors import InputError
from tp_jax.gap.next_run import Finding, Forecast, Run
from tp_jax.schemas.checking import read_versioned
from tp_jax.schemas.exploring import SCHEMA, VERSION

FILE = "explore.json"


@dataclasses.dataclass(frozen=True)
class Made:
    """A run that was recorded, or is about to be.

    Attributes:
        file: name of the recording. run: what was asked of the rig.
        forecast: what was expected of it; None: nothing could be.
        verdict, first, probability: of the diagnosis of it and all before; None: not diagnosed yet.
    """

    file: str
    run: Run
    forecast: Forecast | None = None
    verdict: str | None = None
    first: str | None = None
    probability: float | None = None


@dataclasses.dataclass(frozen=True)
class State:
    """All of it.

    Attributes:
        runs: those that were made, in order.
        next: the run that is being recorded; None: none is.
        finding: of the last diagnosis; None: there was none.
        diagnosed: what that diagnosis is of: the recordings, and what was asked of its forecasts.
    """

    runs: tuple[Made, ...] = ()
    next: Made | None = None
    finding: Finding | None = None
    diagnosed: Mapping[str, Any] | None = None


def read(folder: Path) -> State:
    """The state of an exploration; that of a new one where there is no file.

    Raises:
        InputError: the file cannot be used; the sentence says why.
    """
    file = folder / FILE
    if not file.exists():
        return State()
    content = read_versioned(
        file,
        SCHEMA,
        "the state of an exploration",
        "move it away, and the next one begins from the recordings that are there",
    )
    return State(
        runs=tuple(_made(each) for each in content["runs"]),
        next=None if content["next"] is None else _made(content["next"]),
        finding=None if content["finding"] is None else _finding(content["finding"]),
        diagnosed=content["diagnosed"],
    )


def write(folder: Path, state: State) -> None:
    """Replaces the file.

    Raises:
        InputError: the file system refuses.
    """
    file = folder / FILE
    try:
        write_json(file, {"schema": VERSION, **dataclasses.asdict(state)})
    except OSError as fault:
        raise InputError(f"Cannot write {file}: {fault.strerror}.") from fault


def _made(entry: Mapping[str, Any]) -> Made:
    forecast = entry["forecast"]
    return Made(
        entry["file"],
        Run(**entry["run"]),
        None if forecast is None else _forecast(forecast),
        entry["verdict"],
        entry["first"],
        entry["probability"],
    )


def _forecast(entry: Mapping[str, Any]) -> Forecast:
    return Forecast(Run(**entry["run"]), entry["largest"], entry["log_evidence"])


def _finding(entry: Mapping[str, Any]) -> Finding:
    return Finding(
        entry["verdict"],
        tuple((id, p) for id, p in entry["causes"]),
        entry["first"],
        entry["probability"],
        entry["rivals"],
        tuple(map(_forecast, entry["forecasts"])),
    )
