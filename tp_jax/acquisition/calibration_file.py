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

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import replaced
from tp_jax.acquisition.calibration import PARAMETERS, Calibration, SensorCalibration
from tp_jax.errors import InputError
from tp_jax.schemas.calibration import schema
from tp_jax.schemas.checking import check, read_toml

SCHEMA = schema(PARAMETERS)


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Reads a calibration.

    Raises:
        InputError: the file cannot be read, or says something that is no calibration.
    """
    file = Path(path)
    top = read_toml(file)
    check(top, SCHEMA, str(file))
    return Calibration({name: _sensor(file, name, top[name]) for name in top}, str(file))


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


def _sensor(file: Path, name: str, table: Mapping[str, Any]) -> SensorCalibration:
    law, span = table["law"], table.get("span")
    names = PARAMETERS[law]
    values = np.array([table[key] for key in names], dtype=float)
    if "covariance" in table:
        covariance = np.array(table["covariance"], dtype=float)
    else:
        errors = table.get("errors", {})
        covariance = np.diag(np.square([float(errors.get(key, 0.0)) for key in names]))
    scale = np.sqrt(np.abs(np.diag(covariance)))
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-300) or np.any(
        np.linalg.eigvalsh(covariance) < -1e-9 * max(float(scale.max()) ** 2, 1e-300)
    ):
        raise InputError(
            f"{file}: {name}.covariance is none; make it symmetric, without negatives."
        )
    residual = table.get("residual")
    if span is not None:
        span = (float(span[0]), float(span[1]))
    try:
        return SensorCalibration(
            law, values, covariance, span, None if residual is None else float(residual)
        )
    except InputError as fault:
        raise InputError(f"{file}, [{name}]: {fault}") from fault
