"""Errors that the calibration may have put into the angles of a recording.

An angle read with a calibration that is wrong is wrong in the same way at every sample of that
angle. That is no noise: it does not average out, and it can look like an effect. It is known as a
few smooth shapes over the angle, each of which applies with a number that nobody knows, normal
with standard deviation 1. `tp-jax record` writes them beside a recording, in FILE.csv.meta.json.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.errors import InputError
from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.short import short_fields
from tp_jax.schemas.checking import Misfit, check, read_json
from tp_jax.schemas.recording import SCHEMA, VERSION, metadata_path


@dataclass(frozen=True, eq=False)
class CalibrationError:
    """The error that a calibration leaves in the angles of one sensor.

    The angle read is off by sum_j c_j modes[j](angle), with c_j independent, of mean 0 and
    standard deviation 1, and the same in all recordings made with this calibration.

    Attributes:
        key: names the calibration; recordings with the same one share the numbers c_j.
        angle: (m,) rising angles [rad].
        modes: (q, m) shapes at those angles [rad].
    """

    __repr__ = short_fields

    key: str
    angle: np.ndarray
    modes: np.ndarray

    def at(self, angle: np.ndarray | float) -> np.ndarray:
        """(q, n) shapes [rad] at (n,) angles [rad]."""
        return self._interpolated(self.modes, angle)

    def slope(self, angle: np.ndarray | float) -> np.ndarray:
        """(q, n) slopes of the shapes [rad/rad] at (n,) angles [rad]."""
        return self._interpolated(np.gradient(self.modes, self.angle, axis=1), angle)

    def standard_error(self, angle: np.ndarray | float) -> np.ndarray:
        """(n,) standard errors [rad] of the angle read, at (n,) angles [rad]."""
        return np.sqrt((self.at(angle) ** 2).sum(axis=0))

    def _interpolated(self, values: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
        low, high = self.angle[0], self.angle[-1]
        x = np.asarray(angle, dtype=float)
        if math.isclose(high - low, math.pi):  # such sensors repeat themselves after half a turn
            x = np.where((x < low) | (x > high), low + np.mod(x - low, math.pi), x)
        return np.array([np.interp(x, self.angle, row) for row in values])


def read_calibration_error(recording: Path) -> dict[str, CalibrationError]:
    """Reads what FILE.csv.meta.json says of the calibration: channel -> its error.

    Empty where there is no such file, where it is not that of a recording, or where it names no
    error.

    Raises:
        CampaignError: the file is there and cannot be read.
    """
    file = metadata_path(recording)
    if not file.is_file():
        return {}
    mend = "restore what was recorded, or move the file away"
    try:
        content = read_json(file)
        if not isinstance(content, dict) or content.get("schema") != VERSION:
            return {}
        check(content, SCHEMA, str(file))
    except Misfit as fault:
        raise CampaignError(file, fault.said, mend) from fault
    except InputError as fault:
        wrong = str(fault).removeprefix(f"{file} ").rstrip(".")
        raise CampaignError(file, f"the file {wrong}", mend) from fault
    calibration = content.get("calibration")
    found = {}
    for name, sensor in (calibration or {}).items():
        error = _sensor(file, name, sensor) if isinstance(sensor, dict) else None
        if error is not None:
            found[name] = error
    return found


def _sensor(file: Path, name: str, sensor: Mapping[str, Any]) -> CalibrationError | None:
    told = sensor.get("standard_error")
    if not isinstance(told, dict) or not told.get("modes"):
        return None
    angle = np.array(told["angle"], dtype=float)
    if {len(row) for row in told["modes"]} != {angle.size} or (np.diff(angle) <= 0.0).any():
        raise CampaignError(
            file,
            f"the standard_error of {name} is no list of rising angles with modes of that length",
            "restore what was recorded, or move the file away",
        )
    # null: where a reading says nothing of the angle; the nearest that does stands for it
    modes = np.array(told["modes"], dtype=float)
    known = np.isfinite(modes).all(axis=0)
    if known.sum() < 2 or not modes[:, known].any():
        return None
    key = {key: value for key, value in sensor.items() if key != "standard_error"}
    return CalibrationError(json.dumps(key, sort_keys=True), angle[known], modes[:, known])
