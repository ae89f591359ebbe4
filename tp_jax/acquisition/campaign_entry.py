"""A recording's entry in its campaign.toml, appended to the user's own text.

The entry is put behind the text, and tomllib sees that the whole is TOML. tomlkit, which edits TOML
in place, was tried: it lost an entry behind a last line without an end, mixed line ends, and wrote
a file that was no TOML where `recording` was an inline array.
"""

import json
import os
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tp_jax._files import bytes_of, replaced
from tp_jax.acquisition.run_log import Recorded, metadata_path
from tp_jax.errors import InputError
from tp_jax.recordings import LEAST_SAMPLES, load_campaign
from tp_jax.recordings.checks import check_recording
from tp_jax.recordings.entries import Entry as Entry
from tp_jax.recordings.entries import read_plan
from tp_jax.schemas.checking import read_toml

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

CAMPAIGN = "campaign.toml"


def check_campaign(folder: Path) -> None:
    """Sees before the recording that its entry can be appended; InputError where it cannot."""
    file = folder / CAMPAIGN
    if file.exists():
        _with_entry(file, _read(file), '[[recording]]\nfile = "x.csv"\n')
    elif folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is no folder; give --campaign a folder, which may be new.")
    if folder.exists() and not os.access(folder, os.W_OK):
        raise InputError(f"Cannot write to {folder}: permission denied.")


def entries_of(folder: Path) -> tuple[Entry, ...]:
    """The recordings of the folder's campaign.toml, in order; none where it has none.

    InputError where it cannot be read.
    """
    file = folder / CAMPAIGN
    there = file.exists() and read_toml(file).get("recording")
    return read_plan(file).entries if there else ()


def free_name(folder: Path, omega: float | None) -> Path:
    """A file that is not there yet: run-13.09.csv, run-13.09-2.csv, ...; decay.csv, ..."""
    stem = f"run-{omega:g}" if omega else "decay"
    path, number = folder / f"{stem}.csv", 1
    while os.path.lexists(path) or os.path.lexists(metadata_path(path)):
        number += 1
        path = folder / f"{stem}-{number}.csv"
    return path


def unusable(folder: Path, recorded: Recorded) -> str | None:
    """The fault that keeps a recording out of the folder's campaign; None where it has none."""
    if recorded.rows < LEAST_SAMPLES:
        return f"It has {recorded.rows} samples, but {LEAST_SAMPLES} are needed; record for longer."
    if recorded.state == "complete" and recorded.fault is not None:
        return "Too much of it is missing; see to the rig and record again."
    file = folder / CAMPAIGN
    try:
        rig = _toml(_read(file)).get("rig", {}) if file.exists() else {}
        rate = rig.get("sample_rate")
        made = load_campaign(recorded.path, omega=recorded.omega, decay=not recorded.forced)
        check_recording(made.recordings[0], float(rate) if rate else None)
    except InputError as fault:  # a CampaignError is one
        return str(fault)
    except (AttributeError, TypeError, ValueError):
        return None  # of faults in the campaign's own text its reader knows more
    return None


def append_entry(folder: Path, recorded: Recorded) -> str | None:
    """Appends a recording's entry to the folder's campaign.toml, or to a new one.

    Returns the fault of a recording that stays out, being `unusable`, or None. InputError where the
    file cannot be read, written or appended to.
    """
    file = folder / CAMPAIGN
    try:
        with _alone(folder):
            unfit = unusable(folder, recorded)
            if unfit is not None:
                return unfit
            old = _read(file) if file.exists() else _new(folder, recorded)
            text = _with_entry(file, old, _entry(recorded))
            with replaced(file) as part:
                part.write_text(text, encoding="utf-8", newline="\n")
    except OSError as fault:
        raise InputError(
            f"Cannot write {file}: {fault.strerror}; the recording is in {recorded.path}."
        ) from fault
    return None


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Waits for another recording that ends just now and adds itself to the same campaign.

    The lock is on the folder itself, so that no file is left; it goes with the process. Windows has
    none for folders: there two recordings must not end together.
    """
    if fcntl is None:
        yield
        return
    held = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(held, fcntl.LOCK_EX)
        yield
    finally:
        os.close(held)


def _read(file: Path) -> str:
    try:
        return bytes_of(file).decode("utf-8")
    except OSError as fault:
        raise InputError(f"Cannot read {file}: {fault.strerror}.") from fault
    except UnicodeDecodeError as fault:
        raise InputError(
            f"{file}: the file is no text in UTF-8; save it in that encoding."
        ) from fault


def _toml(text: str) -> dict[str, Any]:
    return tomllib.loads(text.lstrip("\ufeff"))


def _with_entry(file: Path, old: str, entry: str) -> str:
    """The text with the entry at its end; InputError where it would not be a campaign."""
    ends = "\r\n" if "\r\n" in old else "\n"
    gap = "" if not old or old.endswith("\n\n") else "\n" if old.endswith("\n") else "\n\n"
    text = old + (gap + entry).replace("\n", ends)
    try:
        top = _toml(text)
    except (ValueError, RecursionError) as fault:  # TOMLDecodeError is a ValueError
        raise InputError(
            f"{file}: a [[recording]] cannot be appended ({fault}); correct the file, or record "
            "into another folder."
        ) from fault
    if "format" in top:
        raise InputError(
            f"{file}: its [format] is for files of another make; record into another folder."
        )
    return text


def _entry(recorded: Recorded) -> str:
    release = recorded.metadata["drive"]["release"]
    omega = "" if recorded.omega is None else f"omega = {recorded.omega!r}\n"
    remark = "" if release is None else f"  # released at {release:g} rad"
    if recorded.state != "complete":
        remark += f"  # {recorded.state} after {recorded.duration:.4g} s"
    return (
        f"[[recording]]\nfile = {json.dumps(recorded.path.name, ensure_ascii=False)}\n"
        f"{omega}forced = {str(recorded.forced).lower()}{remark}\n"
    )


def _rate(metadata: dict[str, Any]) -> float:
    """Samples a second on the time column, four digits of them.

    Where a wrong clock was corrected they are not those that the rig announces.
    """
    clock = metadata["clock"] or {}
    faster = 1.0 + clock["skew"] if clock.get("applied") else 1.0
    return float(f"{metadata['device']['rate'] * faster:.4g}")


def _new(folder: Path, recorded: Recorded) -> str:
    device = recorded.metadata["device"]
    model = "double" if "phi2" in recorded.metadata["columns"] else "single"
    rate = "" if device is None else f"sample_rate = {_rate(recorded.metadata)!r}\n"
    return (
        f"name = {json.dumps(folder.resolve().name, ensure_ascii=False)}\n\n"
        f'[rig]\nmodel = "{model}"\n'
        "# B1 = 1.2e-3    # kg m^2, the column's, from CAD: fixes the scale of all torques\n" + rate
    )
