"""Calibrations as TOML files.

[phi1]                          # and [phi2]
law = "sine_cosine"             # or "sine", "line"
offset = 1.652                  # V
gain = 2.61                     # V/rad
cosine_offset = 1.648           # sine_cosine only, as zero
cosine_gain = 2.58
zero = 0.012                    # rad
covariance = [[...], ...]       # in this order; or
errors = { offset = 0.001 }     # standard errors, 0 where not given
span = [-0.7, 0.7]              # rad, optional
residual = 0.003                # V, optional
"""

import math
import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from tp_jax._files import replaced
from tp_jax.acquisition.calibration import PARAMETERS, Calibration, SensorCalibration
from tp_jax.errors import InputError

_SENSORS = ("phi1", "phi2")


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Reads a calibration.

    Raises:
        InputError: the file cannot be read, or says something that is no calibration.
    """
    file = Path(path)
    try:
        top = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as fault:
        raise InputError(
            f"{file}: the calibration cannot be read ({(fault.strerror or '').lower()}); name a "
            "file that can be read."
        ) from fault
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as fault:
        raise InputError(f"{file}: the calibration is no TOML ({fault}); mend it there.") from fault
    unknown = [name for name in top if name not in _SENSORS]
    if unknown or "phi1" not in top:
        _fault(file, f"the tables are {sorted(top)}", "have [phi1], and [phi2] if it is measured")
    sensors = {name: _sensor(file, name, table) for name, table in top.items()}
    return Calibration(sensors, str(file))


def write_calibration(path: str | os.PathLike[str], calibration: Calibration) -> None:
    """Writes a calibration; a file that is there is replaced at once and whole."""
    with replaced(path) as part:
        part.write_text(to_toml(calibration), encoding="utf-8", newline="\n")


def to_toml(calibration: Calibration) -> str:
    """The text of the file."""
    text = []
    for name, sensor in calibration.sensors.items():
        text += [f"[{name}]", f'law = "{sensor.law}"']
        text += [f"{key} = {value!r}" for key, value in sensor.parameters.items()]
        text.append("covariance = [")
        text += [f"  [{', '.join(repr(float(x)) for x in row)}]," for row in sensor.covariance]
        text.append("]")
        if sensor.span is not None:
            text.append(f"span = [{sensor.span[0]!r}, {sensor.span[1]!r}]")
        if sensor.residual is not None:
            text.append(f"residual = {sensor.residual!r}")
        text.append("")
    return "\n".join(text)


def _sensor(file: Path, name: str, table: Any) -> SensorCalibration:
    if not isinstance(table, dict):
        _fault(file, f"{name} is no table", f"begin it with [{name}]")
    law = table.get("law")
    if law not in PARAMETERS:
        _fault(file, f"the law of [{name}] is {law!r}", f"write one of {', '.join(PARAMETERS)}")
    names = PARAMETERS[law]
    known = {"law", "covariance", "errors", "span", "residual", *names}
    for key in table:
        if key not in known:
            _fault(file, f'the key "{key}" in [{name}] is unknown', f"keys are {sorted(known)}")
    values = [_number(file, name, key, table.get(key)) for key in names]
    span, residual = table.get("span"), table.get("residual")
    if span is not None:
        if not isinstance(span, list) or len(span) != 2:
            _fault(file, f"the span of [{name}] is no pair", "write span = [-0.7, 0.7]")
        span = (_number(file, name, "span", span[0]), _number(file, name, "span", span[1]))
    if residual is not None:
        residual = _number(file, name, "residual", residual)
    try:
        return SensorCalibration(
            law, np.array(values), _covariance(file, name, table, names), span, residual
        )
    except InputError as fault:
        raise InputError(f"{file}, [{name}]: {fault}") from fault


def _covariance(
    file: Path, name: str, table: Mapping[str, Any], names: tuple[str, ...]
) -> np.ndarray:
    rows, errors = table.get("covariance"), table.get("errors", {})
    if rows is None:
        if not isinstance(errors, dict) or not set(errors) <= set(names):
            _fault(file, f"errors of [{name}] name other than {list(names)}", "correct them")
        known = [_number(file, name, key, errors.get(key, 0.0)) for key in names]
        return np.diag(np.square(known))
    p = len(names)
    square = isinstance(rows, list) and [len(r) if isinstance(r, list) else 0 for r in rows]
    if square != [p] * p:
        _fault(file, f"the covariance of [{name}] is not {p} x {p}", f"give {p} rows of {p}")
    covariance = np.array(
        [[_number(file, name, "covariance", x) for x in row] for row in rows], dtype=float
    )
    scale = np.sqrt(np.abs(np.diag(covariance)))
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-300) or np.any(
        np.linalg.eigvalsh(covariance) < -1e-9 * max(float(scale.max()) ** 2, 1e-300)
    ):
        _fault(file, f"the covariance of [{name}] is none", "make it symmetric, without negatives")
    return covariance


def _number(file: Path, name: str, key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        _fault(file, f"{key} of [{name}] is {value!r}", f"give {key} a finite number")
    return float(value)


def _fault(file: Path, wrong: str, mend: str) -> NoReturn:
    raise InputError(f"{file}: {wrong}; {mend}.")
