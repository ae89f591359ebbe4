"""A calibration run: readings of the bridges at known angles, as CSV, to a calibration.

    phi1,sine1,cosine1
    -0.7854,0.352,1.651
    ...

`phi1` and `phi2` are the known angles, `sine1`, `cosine1`, `sine2` and `cosine2` the volts read at
them. A file has the columns of one sensor or of both; a bridge that is not wired has none.
"""

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tp_jax.acquisition.calibration import Calibration, SensorCalibration
from tp_jax.acquisition.calibration_fit import fit_calibration
from tp_jax.errors import InputError
from tp_jax.recordings.cells import number, split
from tp_jax.recordings.faults import CampaignError, listed, nearest, shortened
from tp_jax.recordings.lines import read_lines

COLUMNS = {"phi1": ("sine1", "cosine1"), "phi2": ("sine2", "cosine2")}
"""Known angle of a sensor -> the volts of its two bridges."""

_KNOWN = [*COLUMNS, *(name for bridges in COLUMNS.values() for name in bridges)]

MOST = 2.0 * math.pi
"""rad; nobody turns a sensor by more to calibrate it, but by so many degrees."""

_SYSTEMATIC = 2.5  # standard errors


@dataclass(frozen=True)
class Run:
    """Readings of one sensor: (n,) known angles [rad], (n, 1 or 2) volts, and where they stood."""

    angles: np.ndarray
    readings: np.ndarray
    files: tuple[str, ...]


def calibrate(
    files: Iterable[str | os.PathLike[str]], law: str | None = None, *, degrees: bool = False
) -> tuple[Calibration, dict[str, Run]]:
    """Fits a calibration to runs.

    Args:
        files: one or more; what several say of a sensor is put together.
        law: see `calibration`; None: sine_cosine where the cosine bridge was read, else sine.
        degrees: the known angles are in degrees.

    Returns:
        The calibration, and the run of each of its sensors.

    Raises:
        InputError: a file cannot be read, says nothing of phi1, or does not determine the law.
    """
    runs: dict[str, Run] = {}
    for file in map(Path, files):
        for name, run in read_run(file, degrees=degrees).items():
            runs[name] = _joined(name, runs[name], run) if name in runs else run
    if "phi1" not in runs:
        raise InputError(
            "No file has a column phi1, but every rig has that sensor; give its run as well."
        )
    sensors: dict[str, SensorCalibration] = {}
    for name in sorted(runs):
        run = runs[name]
        chosen = law or ("sine_cosine" if run.readings.shape[1] == 2 else "sine")
        place = " and ".join(run.files)
        cosine = COLUMNS[name][1]
        if chosen == "sine_cosine" and run.readings.shape[1] < 2:
            raise InputError(
                f"{place}: the law sine_cosine needs a column {cosine}; add it, or choose sine."
            )
        try:
            sensors[name] = fit_calibration(run.angles, run.readings, chosen)
        except InputError as fault:
            raise InputError(f"{place}, {name}: {fault}") from fault
    source = " and ".join(dict.fromkeys(file for run in runs.values() for file in run.files))
    return Calibration(sensors, source), runs


def read_run(file: Path, *, degrees: bool = False) -> dict[str, Run]:
    """Reads a calibration run: "phi1", "phi2" -> what the file says of that sensor.

    Raises:
        CampaignError: the file is none.
    """
    lines = read_lines(file)
    delimiter = "," if "," in lines.text[0] else None
    header = split(lines.text[0].lstrip("# "), delimiter)
    sensors = _sensors(file, header, lines.numbers[0])
    wanted = [name for names in sensors.values() for name in names]
    table = np.empty((len(lines.text) - 1, len(wanted)))
    for i, line in enumerate(lines.text[1:]):
        cells, at = split(line, delimiter), lines.numbers[1 + i]
        if len(cells) != len(header):
            raise CampaignError(
                file,
                f"the row has {len(cells)} cells where the header has {len(header)}",
                "complete or remove it",
                at,
            )
        for j, name in enumerate(wanted):
            cell = cells[header.index(name)]
            value = number(cell, ".")
            if value is None or not np.isfinite(value):
                raise CampaignError(
                    file, f'{name} is no number but "{shortened(cell)}"', "write what was read", at
                )
            table[i, j] = value
    columns = dict(zip(wanted, table.T, strict=True))
    found = {}
    for name, (_, *bridges) in sensors.items():
        angles = np.deg2rad(columns[name]) if degrees else columns[name]
        _check_unit(file, name, columns[name], degrees)
        found[name] = Run(angles, np.column_stack([columns[b] for b in bridges]), (str(file),))
    return found


def follows_the_angle(sensor: SensorCalibration, run: Run) -> bool:
    """Whether the readings leave the law in a way that depends on the angle.

    Their scatter is then no noise, and the errors of the parameters are too small. By von Neumann's
    ratio: residuals of neighbouring angles that are alike.
    """
    width = 2 if sensor.needs_cosine else 1
    order = np.argsort(run.angles, kind="stable")
    left = (run.readings[:, :width] - sensor.volts(run.angles)[:, :width])[order]
    n = len(left)
    ratio = (np.diff(left, axis=0) ** 2).sum(axis=0) / np.maximum((left**2).sum(axis=0), 1e-300)
    error = 2.0 * np.sqrt((n - 2.0) / (n**2 - 1.0))
    return bool((ratio < 2.0 - _SYSTEMATIC * error).any())


def _sensors(file: Path, header: list[str], line: int) -> dict[str, list[str]]:
    """Sensor -> its columns that are there: the known angle, and one bridge or both."""
    for name in header:
        near = None if name in _KNOWN else nearest(name, _KNOWN)
        if near is not None and near not in header:
            raise CampaignError(
                file, f'the column "{name}" is unknown', f'did you mean "{near}"?', line
            )
    found = {}
    for name, (sine, cosine) in COLUMNS.items():
        there = [each for each in (name, sine, cosine) if each in header]
        if there and there[:2] != [name, sine]:
            missing = name if name not in header else sine
            raise CampaignError(
                file, f"{there[-1]} is there without {missing}", f"add a column {missing}", line
            )
        if there:
            found[name] = there
    if not found:
        raise CampaignError(
            file,
            f"the columns are {listed(header)}",
            "begin the file with a header like phi1,sine1,cosine1: known angle, volts",
            line,
        )
    return found


def _check_unit(file: Path, name: str, known: np.ndarray, degrees: bool) -> None:
    """Faults degrees taken for radians, and radians for degrees."""
    apart = float(np.ptp(known)) if known.size else 0.0
    if not degrees and apart > MOST:
        wrong, mend = f"{apart:.4g} rad apart", "add --degrees if they are degrees"
    elif degrees and 0.0 < apart < math.pi:
        wrong, mend = f"only {apart:.4g}° apart", "leave out --degrees if they are radians"
    else:
        return
    raise CampaignError(file, f"the known angles {name} are {wrong}", mend)


def _joined(name: str, first: Run, second: Run) -> Run:
    if first.readings.shape[1] != second.readings.shape[1]:
        raise InputError(
            f"{' and '.join(first.files)} and {second.files[0]} do not have the same columns of "
            f"{name}; give both the same bridges."
        )
    return Run(
        np.concatenate([first.angles, second.angles]),
        np.concatenate([first.readings, second.readings]),
        (*first.files, *second.files),
    )
