"""Making a trial: nothing here knows the model that is put to the test."""

import dataclasses
import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.executors import ExecutorChoice, Piece, run_pieces
from trials.case import PART_OF_KEY, Settings, make_case
from trials.plan import Case, plan_cases
from trials.rough import RoughSettings
from trials.seal import seal, sealed_with

Progress = Callable[[str, float | None], None]

NOTE = "trial.json"
"""File that says what a trial that grows is to be."""


def make(
    directory: str | os.PathLike[str],
    cases: int,
    seed: int = 0,
    *,
    rigs: str = "clean",
    settings: Settings | RoughSettings | None = None,
    executor: ExecutorChoice | None = None,
    progress: Progress | None = None,
) -> str:
    """Makes a sealed trial of campaigns, in which something is hidden or nothing.

    It is made beside its place and put there when it is whole; after an interruption the same
    call goes on where it was.

    Args:
        directory: where to; must be empty or not there.
        cases: how many, in the proportions 200 with one effect of the catalogue, 120 without, 60
            with one from outside it, 60 with two; rough ones `plan.ROUGH_PARTS`.
        seed: of everything random; the same seed makes the same trial, whatever `executor`.
        rigs: "clean": all recorded alike; "rough": see `RoughSettings`.
        settings: how campaigns are made; of the kind that `rigs` says.
        executor: what makes them; None: this process.
        progress: called with a stage's name and the part of it that is done.

    Returns:
        SHA-256 of the key.

    Raises:
        InputError: the directory holds something, there are no cases or no such rigs.
        OSError: a file cannot be written.
    """
    plan = plan_cases(cases, seed, rigs)
    rough = rigs == "rough"
    settings = settings or (RoughSettings() if rough else Settings())
    if rough != isinstance(settings, RoughSettings):
        raise InputError(f"The settings given are not those of {rigs} rigs.")
    kind = {"rigs": rigs} if rough else {}  # clean trials stay what they always were
    # its name is not to be "." or ".."
    root = Path(directory).resolve()
    if root.is_file() or (root.is_dir() and any(root.iterdir())):
        raise InputError(f"{directory} is not empty; give a new folder.")
    part = root.with_name(f".{root.name}.part")
    wanted = {"cases": cases, "seed": seed, **kind, **dataclasses.asdict(settings)}
    digest = _begin(part, wanted, _program())
    if digest is None:
        made: dict[str, dict[str, Any]] = {}
        for name, entry in _made(part, plan, settings, executor):
            made[name] = entry
            if progress is not None:
                progress("making cases", len(made) / len(plan))
        key = {
            "version": __version__,
            "seed": seed,
            **kind,
            "settings": dataclasses.asdict(settings),
            "cases": [made[case.name] for case in plan],
        }
        digest = seal(part, key)
    # what it grew from goes last, so that nothing is lost where this is cut off
    for case in plan:  # each is in the key now
        (part / "sealed" / case.name / PART_OF_KEY).unlink(missing_ok=True)
    if root.is_dir():
        root.rmdir()
    (part / NOTE).unlink(missing_ok=True)
    part.rename(root)
    return digest


def _program() -> str:
    """Digest of the code that makes rigs: a trial begun by another one is not gone on with."""
    digest = hashlib.sha256()
    trials = Path(__file__).parent
    for folder in (trials, trials.parent / "tp_jax" / "rig"):
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _begin(part: Path, wanted: dict[str, Any], program: str) -> str | None:
    """The folder in which a trial grows; what is there of another trial, or program, goes.

    Returns:
        Digest of the key where the trial is sealed already, and was cut off in being put into its
        place.
    """
    note, says = part / NOTE, json.dumps({**wanted, "program": program})
    if part.is_dir():
        digest = sealed_with(part, __version__, wanted)
        if digest is not None:
            return digest
        if note.is_file() and note.read_text(encoding="utf-8") == says:
            return None
        shutil.rmtree(part)
    part.mkdir(parents=True)
    with replaced(note) as file:
        file.write_text(says, encoding="utf-8")
    return None


def _made(
    part: Path,
    plan: list[Case],
    settings: Settings | RoughSettings,
    executor: ExecutorChoice | None,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Cases as they are done."""
    if executor is None:
        for case in plan:
            yield case.name, make_case(part, case, settings)
        return
    # each case keeps its own part of the key
    pieces = [Piece(case.name, (part, case, settings)) for case in plan]
    for ended in run_pieces(make_case, pieces, executor, uses_jax=False):
        if ended.fault is not None:
            raise ended.fault.error()
        yield ended.piece.key, ended.result
