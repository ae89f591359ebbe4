"""Writing results: each file appears whole or not at all, and JSON has no NaN."""

import json
import os
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tp_jax import _files
from tp_jax._files import plain as plain
from tp_jax.errors import InputError
from tp_jax.schemas.recording import metadata_path

if TYPE_CHECKING:
    from tp_jax.simulation.solve import Trajectory

STANDARD_OUTPUT = "-"
CAMPAIGN = "campaign.toml"


@contextmanager
def replaced(target: str | Path) -> Iterator[Path]:
    """A path to write to; what was written takes the target's place when the block ends well.

    As `_files.replaced`; missing folders are made, and what the file system refuses at this place
    is an `InputError`.
    """
    path, part = Path(os.path.realpath(target)), None
    try:
        if path.is_dir():
            raise InputError(f"Cannot write {target}: it is a folder.")
        path.parent.mkdir(parents=True, exist_ok=True)
        with _files.replaced(target) as part:
            yield part
    except BrokenPipeError:
        raise
    except OSError as fault:
        # others, say a template that is missing, are not the target's
        here = fault.filename is None or Path(fault.filename) in (part, path, *path.parents)
        if fault.errno is None or not here:
            raise
        raise InputError(f"Cannot write {target}: {fault.strerror}.") from fault


def made_folder(target: str | Path) -> Path:
    """The folder, made where it is missing: before the work rather than after it."""
    folder = Path(target)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(
            f"Cannot make the folder {shortened(target)}: {fault.strerror}."
        ) from fault
    return folder


def new_folder(name: str) -> Path:
    """A folder that was not there before: the name itself, or name-2, name-3, ..."""
    number = 1
    while (path := Path(name if number == 1 else f"{name}-{number}")).exists():
        number += 1
    return made_folder(path)


def ready(
    *targets: str | Path | None,
    overwrite: bool | None = None,
    inputs: Sequence[str | Path] = (),
) -> None:
    """Sees before the work that its results can be written; None and `-` always can.

    What was derived is replaced, a recording or a campaign.toml is not: nobody can make it anew.

    Args:
        targets: files to be written.
        overwrite: whether a recording may be replaced; None: the command has no such option.
        inputs: files that the command reads, which it never replaces.

    Raises:
        InputError: which cannot, and why.
    """
    for target in targets:
        if target is None or str(target) == STANDARD_OUTPUT:
            continue
        path = Path(os.path.realpath(target))
        try:
            _try(target, path)
            if not overwrite and (is_recording(path) or is_recording(Path(target))):
                option = "" if overwrite is None else ", or add --overwrite to replace it"
                raise InputError(
                    f"{shortened(target)} is a recording; choose another name{option}."
                )
            read = [Path(os.path.realpath(each)) for each in inputs]
            if path in read or (path.name == CAMPAIGN and path.exists()):
                raise InputError(
                    f"The result would replace {shortened(target)}, which cannot be made anew; "
                    "choose another name."
                )
        except InputError:
            raise
        except OSError as fault:
            reason = (fault.strerror or str(fault)).lower()
            raise InputError(f"Cannot write {shortened(target)}: {reason}.") from fault
        except ValueError as fault:  # a null byte
            raise InputError(f"Cannot write {shortened(target)}: {fault}.") from fault


def is_recording(path: Path) -> bool:
    """True if a file has metadata beside it, or a campaign.toml that lists it."""
    if metadata_path(path).exists():
        return True
    if not path.is_file():
        return False
    try:
        top = tomllib.loads((path.parent / CAMPAIGN).read_text(encoding="utf-8-sig"))
        files = [str(each["file"]) for each in top["recording"]]
    except (OSError, ValueError, LookupError, TypeError):  # no campaign, or none that can be read
        return False
    return any(Path(os.path.realpath(path.parent / each)) == path for each in files)


def _try(target: str | Path, path: Path) -> None:
    if path.is_dir():
        raise InputError(f"Cannot write {target}: it is a folder.")
    folder = made_folder(path.parent)
    there = path.exists() and not path.is_file()  # /dev/null is written to in its place
    if not os.access(path if there else folder, os.W_OK):
        raise InputError(f"Cannot write {target}: permission denied.")
    if not there:
        # permissions do not tell all: a file system may be one in which nothing can be made
        with tempfile.TemporaryFile(dir=folder):
            pass


def shortened(target: str | Path) -> str:
    """A path as it can stand in a sentence."""
    text = str(target)
    return text if len(text) <= 120 else f"{text[:60]}...{text[-40:]}"


def forget(file: Path) -> None:
    """Takes away a file of work that is done, and its folder where nothing else is in it."""
    file.unlink(missing_ok=True)
    with suppress(OSError):
        file.parent.rmdir()


def write_text(target: str | Path, text: str) -> None:
    with replaced(target) as part:
        part.write_text(as_text(text), encoding="utf-8")


def as_text(text: str) -> str:
    """The text as files can hold it: names of files may be no text."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def write_json(target: str | Path, result: Mapping[str, Any]) -> None:
    """Writes to a file, or to standard output where the target is `-`."""
    text = as_text(json_text(result))  # a byte that is no text becomes an escape of JSON's own
    if str(target) == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        write_text(target, text)


def json_text(result: Any) -> str:
    return json.dumps(plain(result), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_trajectory(target: str | None, trajectory: "Trajectory") -> None:
    """CSV with the header t,phi1,phi2 (single: t,phi1); without a target to standard output.

    What was known of a recording that was there before is not true of this one, and goes.
    """
    import numpy as np

    from tp_jax.recordings.writer import csv_text

    columns = [np.asarray(trajectory.t), np.asarray(trajectory.phi1)]
    if trajectory.phi2 is not None:
        columns.append(np.asarray(trajectory.phi2))
    if not all(np.isfinite(column).all() for column in columns):
        raise RuntimeError("the solver did not reach the end of the run")

    text = csv_text(*columns)
    if target is None or target == STANDARD_OUTPUT:
        sys.stdout.write(text)
    else:
        write_text(target, text)
        metadata_path(Path(os.path.realpath(target))).unlink(missing_ok=True)
