"""TDMS files of LabVIEW, by npTDMS."""

from pathlib import Path

import numpy as np


def read(file: Path, sheet: str | None) -> dict[str, np.ndarray]:
    """The channels as "group/channel", or those of the group `sheet` by their names.

    Where no channel holds times and the waveform says its step, a column "t" does.
    """
    from nptdms import TdmsFile

    found: dict[str, np.ndarray] = {}
    for group in TdmsFile.read(file).groups():
        if sheet not in (None, group.name):
            continue
        for channel in group.channels():
            if len(channel) == 0:
                continue
            name = channel.name if sheet is not None else f"{group.name}/{channel.name}"
            if "t" not in found and channel.properties.get("wf_increment"):
                found["t"] = np.asarray(channel.time_track())
            found[name] = np.asarray(channel[:])
    return found
