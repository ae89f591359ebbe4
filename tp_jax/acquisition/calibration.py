"""Bridge volts to angles: three laws, their parameters, and how well the angle is known by them.

    line          V = offset + gain θ, as in the paper; 4.5 % low at 15°, folds back beyond 45°
    sine          V = offset + gain ½ sin 2θ, the law of a magnetoresistive bridge
    sine_cosine   V as above for θ + zero, and V' = cosine_offset + cosine_gain ½ cos 2(θ + zero):
                  the two bridges of an HMC1512, 45° apart

so that the gain is the slope in V/rad at θ = 0 in all of them. A magnetoresistive sensor repeats
itself after 180°; `unwrap` follows the angle beyond.

Parameters come with their covariance, which makes the angle's standard error a function of the
angle: one error for all samples of a recording, not a noise, which adds to the noise floor.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.errors import InputError

PARAMETERS: dict[str, tuple[str, ...]] = {
    "line": ("offset", "gain"),
    "sine": ("offset", "gain"),
    "sine_cosine": ("offset", "gain", "cosine_offset", "cosine_gain", "zero"),
}
"""Law -> names of its parameters, in the order of `SensorCalibration.values`."""


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
        gains = [v for name, v in zip(PARAMETERS[self.law], values, strict=True) if "gain" in name]
        if 0.0 in gains:
            raise InputError("A calibration's gain is 0, but must be the slope in volts per rad.")
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "covariance", covariance)

    @property
    def parameters(self) -> dict[str, float]:
        """Name -> value."""
        return {n: float(v) for n, v in zip(PARAMETERS[self.law], self.values, strict=True)}

    @property
    def errors(self) -> dict[str, float]:
        """Name -> standard error."""
        errors = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return {n: float(e) for n, e in zip(PARAMETERS[self.law], errors, strict=True)}

    @property
    def needs_cosine(self) -> bool:
        """Whether the cosine bridge must be wired."""
        return self.law == "sine_cosine"

    def volts(self, angle: ArrayLike) -> np.ndarray:
        """(n, 2) volts of the sine and the cosine bridge at (n,) angles [rad].

        The second column is 0 where the law has no cosine bridge.
        """
        return volts(self.law, self.values, np.asarray(angle, dtype=float))

    def angle(self, readings: ArrayLike) -> np.ndarray:
        """(n,) principal angles [rad] of (n, 2) volts.

        sine: within ±π/4, and volts beyond the law's range stand for its end; sine_cosine: within
        ±π/2 of −zero. `unwrap` goes on from there.
        """
        readings = np.asarray(readings, dtype=float)
        offset, gain = self.values[:2]
        sine = (readings[:, 0] - offset) / gain
        if self.law == "line":
            return sine
        if self.law == "sine":
            return 0.5 * np.arcsin(np.clip(2.0 * sine, -1.0, 1.0))
        _, _, cosine_offset, cosine_gain, zero = self.values
        cosine = (readings[:, 1] - cosine_offset) / cosine_gain
        return 0.5 * np.arctan2(sine, cosine) - zero

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
        p = len(PARAMETERS[self.law])
        if not self.covariance.any():
            return np.zeros((p, angle.size))
        by_parameters, by_angle = _derivatives(self.law, self.values, angle)
        # reading = V(θ, p): an error of p moves the angle read by −(V_θ⁺) V_p
        weight = np.sum(by_angle**2, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            per_parameter = np.einsum("nc,ncp->np", by_angle, by_parameters) / weight[:, None]
        known = weight > (1e-6 * self.values[1]) ** 2
        # of the correlations: parameters of different units
        errors = np.array(list(self.errors.values()))
        scale = np.where(errors > 0.0, errors, 1.0)
        size, direction = np.linalg.eigh(self.covariance / np.outer(scale, scale))
        root = scale[:, None] * direction * np.sqrt(np.maximum(size, 0.0))
        modes = root.T @ np.where(known[:, None], per_parameter, 0.0).T
        return np.where(known, modes, np.inf)


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
    out = np.zeros((angle.size, 2))
    offset, gain = values[:2]
    if law == "line":
        out[:, 0] = offset + gain * angle
    elif law == "sine":
        out[:, 0] = offset + gain * 0.5 * np.sin(2.0 * angle)
    else:
        _, _, cosine_offset, cosine_gain, zero = values
        out[:, 0] = offset + gain * 0.5 * np.sin(2.0 * (angle + zero))
        out[:, 1] = cosine_offset + cosine_gain * 0.5 * np.cos(2.0 * (angle + zero))
    return out


def _derivatives(law: str, values: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2, p) by the parameters and (n, 2) by the angle, volts scaled to unit gain.

    The scaling matters only between the two bridges: the angle read is that of `arctan2`, the
    foot of the perpendicular on the unit circle.
    """
    n = angle.size
    ones, gain = np.ones(n), values[1]
    by_parameters = np.zeros((n, 2, len(values)))
    by_angle = np.zeros((n, 2))
    if law == "line":
        by_parameters[:, 0, 0], by_parameters[:, 0, 1] = ones, angle
        by_angle[:, 0] = gain
        return by_parameters, by_angle
    zero, ratio = (0.0, 1.0) if law == "sine" else (values[4], gain / values[3])
    sine, cosine = np.sin(2.0 * (angle + zero)), np.cos(2.0 * (angle + zero))
    by_parameters[:, 0, 0], by_parameters[:, 0, 1] = ones, 0.5 * sine
    by_angle[:, 0] = gain * cosine
    if law == "sine_cosine":
        by_angle[:, 1] = -gain * sine
        by_parameters[:, 1, 2], by_parameters[:, 1, 3] = ratio, ratio * 0.5 * cosine
        by_parameters[:, 0, 4], by_parameters[:, 1, 4] = by_angle[:, 0], by_angle[:, 1]
    return by_parameters, by_angle


def nominal(reference: float, cosine: bool) -> SensorCalibration:
    """What a sensor is when nothing is known of it, with errors as large as that.

    The amplifiers are taken to centre the bridge in the ADC's range and to fill four fifths of it:
    the gain is good to 15 %, the offset to 3 % of the range.

    Args:
        reference: the ADC's full scale [V].
        cosine: whether the cosine bridge is wired.
    """
    centre, gain = 0.5 * reference, 0.8 * reference
    values, errors = [centre, gain], [0.03 * reference, 0.15 * gain]
    if cosine:
        values += [centre, gain, 0.0]
        errors += [*errors, 0.0]
    law = "sine_cosine" if cosine else "sine"
    return SensorCalibration(law, np.array(values), np.diag(np.square(errors)))
