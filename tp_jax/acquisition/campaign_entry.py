"""A recording's entry in its campaign.toml, appended to what the user wrote there."""

import json
import os
import tomllib
from pathlib import Path

from tp_jax._files import bytes_of, replaced
from tp_jax.acquisition.run_log import Recorded, metadata_path
from tp_jax.errors import InputError
from tp_jax.recordings import LEAST_SAMPLES, load_campaign
from tp_jax.recordings.checks import check_recording

CAMPAIGN = "campaign.toml"


def check_campaign(folder: Path) -> None:
    """Sees before the recording that its entry can be appended.

    Raises:
        InputError: there is a campaign.toml that cannot take one.
    """
    file = folder / CAMPAIGN
    if file.exists():
        _with_entry(file, _read(file), '[[recording]]\nfile = "x.csv"\n')
    elif folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is no folder; give --campaign a folder, which may be new.")
    if folder.exists() and not os.access(folder, os.W_OK):
        raise InputError(f"Cannot write to {folder}: permission denied.")


def free_name(folder: Path, omega: float | None) -> Path:
    """A file that is not there yet: run-13.09.csv, run-13.09-2.csv, ...; decay.csv, ..."""
    stem = f"run-{omega:g}" if omega else "decay"
    number = 1
    while True:
        path = folder / (f"{stem}.csv" if number == 1 else f"{stem}-{number}.csv")
        if not (os.path.lexists(path) or os.path.lexists(metadata_path(path))):
            return path
        number += 1


def unusable(folder: Path, recorded: Recorded) -> str | None:
    """Why a recording would spoil the campaign in the folder, in one sentence; None: it would not.

    One without motion, say, would keep the whole campaign from being read.
    """
    if recorded.rows < LEAST_SAMPLES:
        return f"It has {recorded.rows} samples, but {LEAST_SAMPLES} are needed; record for longer."
    file = folder / CAMPAIGN
    try:
        rig = tomllib.loads(_read(file).lstrip("\ufeff")).get("rig", {}) if file.exists() else {}
        rate = rig.get("sample_rate")
        made = load_campaign(recorded.path, omega=recorded.omega, decay=not recorded.forced)
        check_recording(made.recordings[0], float(rate) if rate else None)
    except InputError as fault:  # a CampaignError is one
        return str(fault)
    except (AttributeError, TypeError, ValueError):
        return None  # of what is wrong with the campaign's own text its reader knows more
    return None


def append_entry(folder: Path, recorded: Recorded) -> bool:
    """Appends the entry of a recording in the folder; makes the campaign.toml where there is none.

    Returns:
        Whether it was appended: a recording that is `unusable` is not.

    Raises:
        InputError: the campaign.toml cannot be read, written or appended to; the recording stays.
    """
    if unusable(folder, recorded) is not None:
        return False
    file = folder / CAMPAIGN
    entry = _entry(recorded)
    try:
        old = _read(file) if file.exists() else _new(folder, recorded)
        text = _with_entry(file, old, entry)
        with replaced(file) as part:
            part.write_text(text, encoding="utf-8", newline="\n")
    except OSError as fault:
        raise InputError(
            f"Cannot write {file}: {fault.strerror}; the recording is in {recorded.path}."
        ) from fault
    return True


def _read(file: Path) -> str:
    try:
        return bytes_of(file).decode("utf-8")
    except OSError as fault:
        raise InputError(f"Cannot read {file}: {fault.strerror}.") from fault
    except UnicodeDecodeError as fault:
        raise InputError(
            f"{file}: the file is no text in UTF-8; save it in that encoding."
        ) from fault


def _with_entry(file: Path, old: str, entry: str) -> str:
    """The text with the entry at its end; nothing of the old one changes.

    Raises:
        InputError: it would not be a campaign.
    """
    ends = "\r\n" if "\r\n" in old else "\n"
    gap = "" if not old or old.endswith("\n\n") else "\n" if old.endswith("\n") else "\n\n"
    text = old + (gap + entry).replace("\n", ends)
    try:
        top = tomllib.loads(text.lstrip("\ufeff"))
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
    lines = ["[[recording]]", f"file = {json.dumps(recorded.path.name, ensure_ascii=False)}"]
    if recorded.omega is not None:
        lines.append(f"omega = {recorded.omega!r}")
    lines.append(f"forced = {str(recorded.forced).lower()}")
    release = recorded.metadata["drive"]["release"]
    if release is not None:
        lines[-1] += f"  # released at {release:g} rad"
    if recorded.state != "complete":
        lines[-1] += f"  # {recorded.state} after {recorded.duration:.4g} s"
    return "\n".join(lines) + "\n"


def _new(folder: Path, recorded: Recorded) -> str:
    device = recorded.metadata["device"]
    model = "double" if "phi2" in recorded.metadata["columns"] else "single"
    lines = [
        f"name = {json.dumps(folder.resolve().name, ensure_ascii=False)}",
        "",
        "[rig]",
        f'model = "{model}"',
        "# B1 = 1.2e-3    # kg m^2, the column's, from CAD: fixes the scale of all torques",
    ]
    if device is not None:
        lines.append(f"sample_rate = {device['rate']!r}")
    return "\n".join(lines) + "\n"
