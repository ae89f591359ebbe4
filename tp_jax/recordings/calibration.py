"""Bridge volts to angles: three laws, their parameters, and how well an angle is known by them.

    line          V = offset + gain θ, as in the paper; 4.5 % low at 15°, folds back beyond 45°
    sine          V = offset + gain ½ sin 2θ, the law of a magnetoresistive bridge
    sine_cosine   V as above for θ + zero, and V' = cosine_offset + cosine_gain ½ cos 2(θ + zero):
                  the two bridges of an HMC1512, 45° apart

The gain is the slope in V/rad at θ = 0 in all of them. A magnetoresistive sensor repeats itself
after 180°; `unwrap` follows the angle beyond. The covariance of the parameters gives the angle's
standard error: one error for all samples of a recording, which no averaging removes.

A calibration file:

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
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.schemas.calibration import schema
from tp_jax.schemas.checking import check, read_toml

PARAMETERS: dict[str, tuple[str, ...]] = {
    "line": ("offset", "gain"),
    "sine": ("offset", "gain"),
    "sine_cosine": ("offset", "gain", "cosine_offset", "cosine_gain", "zero"),
}
"""Law -> names of its parameters, in the order of `SensorCalibration.values`."""

_STEP = 1e-30  # of a complex-step derivative, which rounds nothing off however small it is


@dataclass(frozen=True, eq=False)
class SensorCalibration:
    """The calibration of one sensor.

    Attributes:
        law: "line", "sine" or "sine_cosine".
        values: (p,) parameters in the order of `PARAMETERS[law]`; offsets [V], gains [V/rad],
            zero [rad].
        covariance: (p, p) of their errors; zeros where they are not known.
        span: (low, high) angles [rad] it was taken at; None where nobody said.
        residual: rms of the readings about the law [V]; None where nobody said.
    """

    law: str
    values: np.ndarray
    covariance: np.ndarray
    span: tuple[float, float] | None = None
    residual: float | None = None

    def __post_init__(self) -> None:
        if self.law not in PARAMETERS:
            raise InputError(
                f'The calibration has the law "{self.law}", but it must be one of '
                f"{', '.join(PARAMETERS)}."
            )
        p = len(PARAMETERS[self.law])
        values = np.asarray(self.values, dtype=float)
        covariance = np.asarray(self.covariance, dtype=float)
        if values.shape != (p,) or covariance.shape != (p, p):
            raise InputError(
                f"A calibration by the law {self.law} must have {p} values and a {p} x {p} "
                f"covariance, but has {values.shape} and {covariance.shape}."
            )
        if not (np.isfinite(values).all() and np.isfinite(covariance).all()):
            raise InputError("A calibration's values and covariance must be finite numbers.")
        if 0.0 in values[[1, 3] if self.needs_cosine else [1]]:
            raise InputError("A calibration's gain is 0, but must be the slope in volts per rad.")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "covariance", covariance)

    @property
    def parameters(self) -> dict[str, float]:
        """Name -> value."""
        return dict(zip(PARAMETERS[self.law], self.values.tolist(), strict=True))

    @property
    def errors(self) -> dict[str, float]:
        """Name -> standard error."""
        errors = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return dict(zip(PARAMETERS[self.law], errors.tolist(), strict=True))

    @property
    def needs_cosine(self) -> bool:
        """True where the cosine bridge must be wired."""
        return self.law == "sine_cosine"

    def volts(self, angle: ArrayLike) -> np.ndarray:
        """(n, 2) volts of the sine and the cosine bridge, 0 where there is none, at (n,) angles."""
        return volts(self.law, self.values, np.asarray(angle, dtype=float))

    def angle(self, readings: ArrayLike) -> np.ndarray:
        """(n,) principal angles [rad] of (n, 2) volts.

        sine: within ±π/4, and volts beyond the law's range stand for its end; sine_cosine: within
        ±π/2 of −zero. `unwrap` goes on from there.
        """
        readings = np.asarray(readings, dtype=float)
        sine = (readings[:, 0] - self.values[0]) / self.values[1]
        if self.law == "line":
            return sine
        if self.law == "sine":
            return 0.5 * np.arcsin(np.clip(2.0 * sine, -1.0, 1.0))
        _, _, offset, gain, zero = self.values
        return 0.5 * np.arctan2(sine, (readings[:, 1] - offset) / gain) - zero

    def standard_error(self, angle: ArrayLike) -> np.ndarray:
        """(n,) standard errors [rad], by the parameters' covariance, at (n,) angles [rad].

        Where the sine law folds back, at ±π/4, a reading says nothing of the angle: infinite.
        """
        return np.sqrt((self.error_modes(angle) ** 2).sum(axis=0))

    def error_modes(self, angle: ArrayLike) -> np.ndarray:
        """(p, n) shapes [rad] that make up the error at (n,) angles [rad].

        The angle read is off by their sum, each times a number of its own, normal with standard
        deviation 1, that is the same at all angles. Infinite where `standard_error` is.
        """
        angle = np.asarray(angle, dtype=float)
        p = self.values.size
        if not self.covariance.any():
            return np.zeros((p, angle.size))
        # the angle read is that of arctan2, the foot of the perpendicular on the unit circle: there
        # both bridges have the same gain
        scale = np.array([1.0, self.values[1] / self.values[3] if self.needs_cosine else 1.0])
        by_angle = scale * np.imag(volts(self.law, self.values, angle + _STEP * 1j)) / _STEP
        moved = [volts(self.law, self.values + _STEP * 1j * unit, angle) for unit in np.eye(p)]
        by_parameters = scale * np.imag(moved) / _STEP
        # reading = V(θ, p): an error of p moves the angle read by −(V_θ⁺) V_p
        weight = np.sum(by_angle**2, axis=1)
        known = weight > (1e-6 * self.values[1]) ** 2
        moves = np.sum(by_angle * by_parameters, axis=2) / np.where(known, weight, 1.0)
        # the root of the correlations, since the parameters have different units
        errors = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        unit = np.where(errors > 0.0, errors, 1.0)
        size, direction = np.linalg.eigh(self.covariance / np.outer(unit, unit))
        root = unit[:, None] * direction * np.sqrt(np.maximum(size, 0.0))
        return np.where(known, root.T @ np.where(known, moves, 0.0), np.inf)


@dataclass(frozen=True)
class Calibration:
    """The calibrations of a rig's sensors.

    Attributes:
        sensors: "phi1", "phi2" -> calibration; a single pendulum has phi1 only.
        source: where it comes from, in words: a file, the rig, nominal values.
    """

    sensors: Mapping[str, SensorCalibration] = field(default_factory=dict)
    source: str = ""


def volts(law: str, values: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(n, 2) volts at (n,) angles, by a law and its parameters; see `SensorCalibration`."""
    offset, gain = values[:2]
    if law == "line":
        return np.stack([offset + gain * angle, 0.0 * angle], axis=1)
    if law == "sine":
        return np.stack([offset + gain * 0.5 * np.sin(2.0 * angle), 0.0 * angle], axis=1)
    _, _, cosine_offset, cosine_gain, zero = values
    twice = 2.0 * (angle + zero)
    sine, cosine = 0.5 * np.sin(twice), 0.5 * np.cos(twice)
    return np.stack([offset + gain * sine, cosine_offset + cosine_gain * cosine], axis=1)


def nominal(reference: float, cosine: bool) -> SensorCalibration:
    """The calibration of a sensor of which nothing is known, with errors as large as that.

    The amplifiers are taken to centre the bridge in the ADC's range and to fill four fifths of it:
    the gain is good to 15 %, the offset to 3 % of the range.

    Args:
        reference: the ADC's full scale [V].
        cosine: whether the cosine bridge is wired.
    """
    values, errors = [0.5 * reference, 0.8 * reference], [0.03 * reference, 0.12 * reference]
    if cosine:
        values, errors = [*values, *values, 0.0], [*errors, *errors, 0.0]
    law = "sine_cosine" if cosine else "sine"
    return SensorCalibration(law, np.array(values), np.diag(np.square(errors)))


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Reads a calibration file.

    Raises:
        InputError: the file cannot be read, or says something that is no calibration.
    """
    file = Path(path)
    top = read_toml(file)
    check(top, schema(PARAMETERS), str(file))
    return Calibration({name: _sensor(file, name, top[name]) for name in top}, str(file))


def write_calibration(path: str | os.PathLike[str], calibration: Calibration) -> None:
    """Writes a calibration; a file that is there is replaced at once and whole."""
    with replaced(path) as part:
        part.write_text(to_toml(calibration), encoding="utf-8", newline="\n")


def to_toml(calibration: Calibration) -> str:
    """The text of a calibration file."""
    text = []
    for name, sensor in calibration.sensors.items():
        text += [f"[{name}]", f'law = "{sensor.law}"']
        text += [f"{key} = {value!r}" for key, value in sensor.parameters.items()]
        text += ["covariance = [", *(f"  {row}," for row in sensor.covariance.tolist()), "]"]
        if sensor.span is not None:
            text.append(f"span = {list(sensor.span)}")
        if sensor.residual is not None:
            text.append(f"residual = {sensor.residual!r}")
        text.append("")
    return "\n".join(text)


def calibration_entry(
    calibration: Calibration, spans: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    """The calibration in a recording's metadata, which `calibration_error` reads back.

    Args:
        calibration: of the rig.
        spans: sensor -> least and largest angle [rad] recorded, where there are any yet.
    """
    entry: dict[str, Any] = {"source": calibration.source}
    for name, sensor in calibration.sensors.items():
        low, high = spans.get(name, (-0.25 * math.pi, 0.25 * math.pi))
        if high - low >= math.pi and sensor.law != "line":
            # a bridge repeats itself after half a turn: a ring that winds needs no more of it
            low, high = -0.5 * math.pi, 0.5 * math.pi
        angle = np.linspace(low, max(high, low + 1e-3), 25)  # of a body that never moved as well
        error, modes = sensor.standard_error(angle), sensor.error_modes(angle)
        entry[name] = {
            "law": sensor.law,
            **sensor.parameters,
            "errors": sensor.errors,
            "covariance": sensor.covariance,
            "span": sensor.span,
            "residual": sensor.residual,
            "standard_error": {
                "angle": angle,
                "value": error,
                "modes": modes[modes.any(axis=1)],
                "largest": float(error.max()),
            },
        }
    return entry


def _sensor(file: Path, name: str, table: Mapping[str, Any]) -> SensorCalibration:
    names = PARAMETERS[table["law"]]
    errors = [table.get("errors", {}).get(key, 0.0) for key in names]
    covariance = np.array(table.get("covariance", np.diag(np.square(errors))), dtype=float)
    largest = max(float(np.abs(np.diag(covariance)).max()), 1e-300)
    if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-300) or np.any(
        np.linalg.eigvalsh(covariance) < -1e-9 * largest
    ):
        raise InputError(
            f"{file}: {name}.covariance is none; make it symmetric, without negatives."
        )
    span, residual = table.get("span"), table.get("residual")
    try:
        return SensorCalibration(
            table["law"],
            np.array([table[key] for key in names], dtype=float),
            covariance,
            None if span is None else (float(span[0]), float(span[1])),
            None if residual is None else float(residual),
        )
    except InputError as fault:
        raise InputError(f"{file}, [{name}]: {fault}") from fault
