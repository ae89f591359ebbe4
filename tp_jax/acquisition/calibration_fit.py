"""A calibration from a run with known angles."""

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.acquisition.calibration import PARAMETERS, SensorCalibration, volts
from tp_jax.errors import InputError


def fit_calibration(
    angles: ArrayLike, readings: ArrayLike, law: str = "sine_cosine"
) -> SensorCalibration:
    """Least squares of the readings about a law.

    The covariance is that of the parameters for the scatter found about the law, which holds the
    noise of the readings, the errors of the known angles, and what the law itself gets wrong.

    Args:
        angles: (n,) known angles [rad].
        readings: (n,) volts of the sine bridge, or (n, 2) of the sine and the cosine bridge.
        law: "line", "sine" or "sine_cosine".

    Raises:
        InputError: the law is unknown, the shapes do not fit it, there are too few angles, or
            they do not determine the parameters.
    """
    from scipy.optimize import least_squares  # here, since recording does without SciPy

    if law not in PARAMETERS:
        raise InputError(f'The law must be one of {", ".join(PARAMETERS)}, but is "{law}".')
    theta = np.asarray(angles, dtype=float)
    seen = np.asarray(readings, dtype=float)
    seen = seen[:, None] if seen.ndim == 1 else seen
    wanted = 2 if law == "sine_cosine" else 1
    if theta.ndim != 1 or seen.ndim != 2 or len(seen) != theta.size or seen.shape[1] < wanted:
        raise InputError(
            f"The law {law} needs (n,) angles and (n, {wanted}) readings, but they have the "
            f"shapes {np.shape(angles)} and {np.shape(readings)}."
        )
    if not (np.isfinite(theta).all() and np.isfinite(seen).all()):
        raise InputError("The angles and readings of a calibration run must be finite numbers.")
    seen = seen[:, :wanted]
    p = len(PARAMETERS[law])
    if seen.size <= p or np.unique(theta).size < (3 if wanted == 2 else 2):
        raise InputError(
            f"The law {law} has {p} parameters, but {np.unique(theta).size} known angles do not "
            "determine them with an error; turn the sensor to more angles."
        )

    def residuals(values: np.ndarray) -> np.ndarray:
        return (volts(law, values, theta)[:, :wanted] - seen).ravel()

    fit = least_squares(residuals, _start(law, theta, seen), x_scale="jac", xtol=1e-14, ftol=1e-14)
    freedom = seen.size - p
    scatter = float(fit.fun @ fit.fun) / freedom
    # of the information matrix scaled to a unit diagonal: parameters of different units
    scale = np.sqrt(np.sum(fit.jac**2, axis=0))
    if not scale.all() or np.linalg.cond(fit.jac / scale) > 1e7:
        raise InputError(
            f"The known angles, {np.ptp(theta):.3g} rad apart, do not determine the {p} parameters "
            f"of the law {law}; turn the sensor further, or fit a simpler law."
        )
    jac = fit.jac / scale
    covariance = scatter * np.linalg.inv(jac.T @ jac) / np.outer(scale, scale)
    return SensorCalibration(
        law=law,
        values=fit.x,
        covariance=0.5 * (covariance + covariance.T),
        span=(float(theta.min()), float(theta.max())),
        residual=float(np.sqrt(scatter)),
    )


def _start(law: str, theta: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Parameters to start from: the laws are linear but for zero, which a coarse grid covers."""
    if law != "sine_cosine":
        shape = theta if law == "line" else 0.5 * np.sin(2.0 * theta)
        columns = np.column_stack([np.ones(theta.size), shape])
        return np.linalg.lstsq(columns, seen[:, 0], rcond=None)[0]
    best, least = np.zeros(5), np.inf
    for zero in np.linspace(-0.5 * np.pi, 0.5 * np.pi, 24, endpoint=False):
        values, misfit = [], 0.0
        for column, shape in enumerate((np.sin, np.cos)):
            columns = np.column_stack([np.ones(theta.size), 0.5 * shape(2.0 * (theta + zero))])
            solution = np.linalg.lstsq(columns, seen[:, column], rcond=None)[0]
            misfit += float(np.sum((columns @ solution - seen[:, column]) ** 2))
            values += list(solution)
        # a half turn of zero changes the sign of both gains: the sensor's own is positive
        if misfit < least * (1.0 - 1e-9) and values[1] > 0.0 and values[3] > 0.0:
            best, least = np.array([*values, zero]), misfit
    if not np.isfinite(least):
        raise InputError(
            "No law of two bridges with gains above zero fits these readings; exchange the two "
            "bridges or turn the leads of one of them round."
        )
    return best
