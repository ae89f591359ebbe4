"""A calibration run: readings of the bridges at known angles, as CSV, to a calibration.

    phi1,sine1,cosine1
    -0.7854,0.352,1.651
    ...

`phi1` and `phi2` are the known angles, `sine1`, `cosine1`, `sine2` and `cosine2` the volts read at
them. A file has the columns of one sensor or of both; a bridge that is not wired has none.
"""

import math
import os
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.errors import InputError
from tp_jax.recordings.calibration import PARAMETERS, Calibration, SensorCalibration, volts
from tp_jax.recordings.cells import number, split
from tp_jax.recordings.faults import CampaignError, listed, nearest, shortened
from tp_jax.recordings.lines import read_lines

COLUMNS = {"phi1": ("sine1", "cosine1"), "phi2": ("sine2", "cosine2")}
"""Known angle of a sensor -> the volts of its two bridges."""

_KNOWN = [*COLUMNS, *(name for bridges in COLUMNS.values() for name in bridges)]

MOST = 2.0 * math.pi
"""rad; nobody turns a sensor by more to calibrate it, but by so many degrees."""

_SYSTEMATIC = 2.5  # standard errors
_SINGULAR = 1e14  # condition of the parameters' correlations from which on they are not determined


@dataclass(frozen=True)
class Run:
    """Readings of one sensor: (n,) known angles [rad], (n, 1 or 2) volts, and where they stood."""

    angles: np.ndarray
    readings: np.ndarray
    files: tuple[str, ...]


def calibrate(
    files: Iterable[str | os.PathLike[str]], law: str | None = None, *, degrees: bool = False
) -> tuple[Calibration, dict[str, Run]]:
    """Fits a calibration to runs; all that several files say of a sensor is put together.

    Args:
        files: one or more.
        law: see `calibration`; None: sine_cosine where the cosine bridge was read, else sine.
        degrees: the known angles are in degrees.

    Returns:
        The calibration, and the run of each of its sensors.

    Raises:
        InputError: a file cannot be read, says nothing of phi1, or does not determine the law.
    """
    runs: dict[str, Run] = {}
    for file in map(Path, files):
        for name, run in _read_run(file, degrees).items():
            runs[name] = _joined(name, runs[name], run) if name in runs else run
    if "phi1" not in runs:
        raise InputError(
            "No file has a column phi1, but every rig has that sensor; give its run as well."
        )
    sensors: dict[str, SensorCalibration] = {}
    for name, run in sorted(runs.items()):
        both, place = run.readings.shape[1] == 2, " and ".join(run.files)
        chosen = law or ("sine_cosine" if both else "sine")
        if chosen == "sine_cosine" and not both:
            raise InputError(
                f"{place}: the law sine_cosine needs a column {COLUMNS[name][1]}; add it, or "
                "choose sine."
            )
        try:
            sensors[name] = fit_calibration(run.angles, run.readings, chosen)
        except InputError as fault:
            raise InputError(f"{place}, {name}: {fault}") from fault
    source = " and ".join(dict.fromkeys(file for run in runs.values() for file in run.files))
    return Calibration(sensors, source), runs


def fit_calibration(
    angles: ArrayLike, readings: ArrayLike, law: str = "sine_cosine"
) -> SensorCalibration:
    """Least squares of the readings about a law.

    The covariance is that of the parameters for the scatter found about the law, which holds the
    noise of the readings, the errors of the known angles, and the law's own error.

    Args:
        angles: (n,) known angles [rad].
        readings: (n,) volts of the sine bridge, or (n, 2) of the sine and the cosine bridge.
        law: "line", "sine" or "sine_cosine".

    Raises:
        InputError: the law is unknown, the shapes do not fit it, there are too few angles, or
            they do not determine the parameters.
    """
    from scipy.optimize import OptimizeWarning, curve_fit  # recording does without SciPy

    if law not in PARAMETERS:
        raise InputError(f'The law must be one of {", ".join(PARAMETERS)}, but is "{law}".')
    theta, seen = np.asarray(angles, dtype=float), np.asarray(readings, dtype=float)
    seen = seen[:, None] if seen.ndim == 1 else seen
    wanted, p = (2 if law == "sine_cosine" else 1), len(PARAMETERS[law])
    if theta.ndim != 1 or seen.ndim != 2 or len(seen) != theta.size or seen.shape[1] < wanted:
        raise InputError(
            f"The law {law} needs (n,) angles and (n, {wanted}) readings, but they have the "
            f"shapes {np.shape(angles)} and {np.shape(readings)}."
        )
    if not (np.isfinite(theta).all() and np.isfinite(seen).all()):
        raise InputError("The angles and readings of a calibration run must be finite numbers.")
    target = seen[:, :wanted].ravel()
    if target.size <= p or np.unique(theta).size < wanted + 1:
        raise InputError(
            f"The law {law} has {p} parameters, but {np.unique(theta).size} known angles do not "
            "determine them with an error; turn the sensor to more angles."
        )

    def model(theta: np.ndarray, *values: float) -> np.ndarray:
        return volts(law, np.array(values), theta)[:, :wanted].ravel()

    def fit(start: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        options = {"absolute_sigma": True, "ftol": 1e-13, "xtol": 1e-13}
        return curve_fit(model, theta, target, start, **options)

    undetermined = InputError(
        f"The known angles, {np.ptp(theta):.3g} rad apart, do not determine the {p} parameters "
        f"of the law {law}; turn the sensor further, or fit a simpler law."
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)  # its infinite covariance is seen below
        try:
            # linear but for the zero: any start will do there
            start = _start(model, fit, theta, target) if wanted == 2 else np.ones(p)
            values, inverse = fit(start)
        except RuntimeError:  # no convergence
            raise undetermined from None
    errors = np.sqrt(np.diag(inverse))
    if not (np.isfinite(inverse).all() and errors.all()) or (
        np.linalg.cond(inverse / np.outer(errors, errors)) > _SINGULAR
    ):
        raise undetermined
    scatter = float(np.sum((model(theta, *values) - target) ** 2)) / (target.size - p)
    return SensorCalibration(
        law=law,
        values=values,
        covariance=scatter * 0.5 * (inverse + inverse.T),
        span=(float(theta.min()), float(theta.max())),
        residual=math.sqrt(scatter),
    )


def follows_the_angle(sensor: SensorCalibration, run: Run) -> bool:
    """Tells readings that leave the law in a way that depends on the angle.

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


def _start(model, fit, theta: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The best of the fits of two bridges from four zeros, with gains above zero.

    A half turn of zero changes the sign of both gains: of the two the sensor's own is positive.
    """
    zeros = np.arange(4) * math.pi / 8.0
    found = [fit([0.0, 1.0, 0.0, 1.0, zero])[0] for zero in zeros]
    best = min(found, key=lambda values: float(np.sum((model(theta, *values) - target) ** 2)))
    if best[1] < 0.0:
        best = best * [1.0, -1.0, 1.0, -1.0, 1.0] + [0.0, 0.0, 0.0, 0.0, 0.5 * math.pi]
    if best[3] <= 0.0:
        raise InputError(
            "No law of two bridges with gains above zero fits these readings; exchange the two "
            "bridges or turn the leads of one of them round."
        )
    best[4] = (best[4] + 0.5 * math.pi) % math.pi - 0.5 * math.pi
    return best


def _read_run(file: Path, degrees: bool) -> dict[str, Run]:
    """Reads a calibration run: "phi1", "phi2" -> the readings of that sensor.

    Raises:
        CampaignError: the file is none.
    """
    lines = read_lines(file)
    delimiter = "," if "," in lines.text[0] else None
    header = split(lines.text[0].lstrip("# "), delimiter)
    sensors = _sensors(file, header, lines.numbers[0])
    wanted = [name for names in sensors.values() for name in names]
    table: dict[str, list[float]] = {name: [] for name in wanted}
    for line, at in zip(lines.text[1:], lines.numbers[1:], strict=True):
        cells = split(line, delimiter)
        if len(cells) != len(header):
            wrong = f"the row has {len(cells)} cells where the header has {len(header)}"
            raise CampaignError(file, wrong, "complete or remove it", at)
        for name in wanted:
            cell = cells[header.index(name)]
            value = number(cell, ".")
            if value is None or not math.isfinite(value):
                wrong = f'{name} is no number but "{shortened(cell)}"'
                raise CampaignError(file, wrong, "write what was read", at)
            table[name].append(value)
    found = {}
    for name, (_, *bridges) in sensors.items():
        angles = np.array(table[name])
        _check_unit(file, name, angles, degrees)
        readings = np.array([table[bridge] for bridge in bridges]).T
        found[name] = Run(np.deg2rad(angles) if degrees else angles, readings, (str(file),))
    return found


def _sensors(file: Path, header: list[str], line: int) -> dict[str, list[str]]:
    """Sensor -> its columns that are there: the known angle, and one bridge or both."""
    for name in header:
        near = None if name in _KNOWN else nearest(name, _KNOWN)
        if near is not None and near not in header:
            raise CampaignError(
                file, f'the column "{name}" is unknown', f'did you mean "{near}"?', line
            )
    found = {}
    for name, bridges in COLUMNS.items():
        there = [each for each in (name, *bridges) if each in header]
        if there and there[:2] != [name, bridges[0]]:
            missing = name if name not in header else bridges[0]
            raise CampaignError(
                file, f"{there[-1]} is there without {missing}", f"add a column {missing}", line
            )
        if there:
            found[name] = there
    if not found:
        mend = "begin the file with a header like phi1,sine1,cosine1: known angle, volts"
        raise CampaignError(file, f"the columns are {listed(header)}", mend, line)
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
