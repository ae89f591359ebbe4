"""Amplitude of the drive in an exploration: one for all its runs, as a campaign has one."""

import json
from pathlib import Path
from typing import Any

from tp_jax._files import bytes_of
from tp_jax.acquisition.campaign_entry import entries_of
from tp_jax.acquisition.run_log import metadata_path
from tp_jax.errors import InputError

SAME = 2e-6
"""Amplitudes that differ by less [rad] are one: commands and announcements are in microradians."""


def amplitude_of(folder: Path, asked: float | None, announced: float | None) -> float | None:
    """Amplitude to command in every driven run [rad]; None: the rig's own.

    Forecasts are for the amplitude of the runs that are there, and limits are held by forecasts: a
    rig that is driven further than that would be driven blindly. A rig goes on with the amplitude
    that it was last told, so that its own need not be that of the campaign.

    Args:
        folder: of the campaign.
        asked: by the user; None: nothing was said.
        announced: by the rig; None: it says none.

    Raises:
        InputError: runs of the campaign were driven at another amplitude than was asked for.
    """
    driven = [
        (entry.name, amplitude)
        for entry in entries_of(folder)
        if entry.forced and (amplitude := _driven_at(metadata_of(entry.file))) is not None
    ]
    for name, amplitude in driven:
        if asked is not None and abs(amplitude - asked) > SAME:
            raise InputError(
                f"{name} was driven at {amplitude:.6g} rad, and a campaign has one amplitude; give "
                f"--amplitude {amplitude:.6g}, or another --campaign."
            )
    if asked is not None or not driven:
        return asked
    latest = driven[-1][1]
    return None if announced is not None and abs(announced - latest) <= SAME else latest


def announced_amplitude(folder: Path) -> float | None:
    """Amplitude of the drive [rad] that the rig announced with the latest recording, or None."""
    for entry in reversed(entries_of(folder)):
        amplitude = _number(metadata_of(entry.file), "device")
        if amplitude is not None:
            return amplitude
    return None


def metadata_of(recording: Path) -> dict[str, Any]:
    """Reads what is known of a recording; nothing where nobody wrote it down."""
    try:
        content = json.loads(bytes_of(metadata_path(recording)))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _driven_at(metadata: dict[str, Any]) -> float | None:
    """The amplitude that a run was told, or else that which its rig announced before it."""
    told = _number(metadata, "drive")
    return _number(metadata, "device") if told is None else told


def _number(metadata: dict[str, Any], part: str) -> float | None:
    found = metadata.get(part)
    amplitude = found.get("amplitude") if isinstance(found, dict) else None
    return float(amplitude) if isinstance(amplitude, int | float) else None
