"""Angles, velocities and accelerations from noisy samples: local polynomials."""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tp_jax.recordings.gaps import stretches


class Smoothed(NamedTuple):
    """A smoothed channel and its derivatives, each (n,), with standard errors.

    They are those of the noise, and larger where the polynomial leaves clearly more than noise: a
    window that is long against the motion is one that it cannot follow, and is wrong at its middle
    by about as much as it leaves.
    """

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray
    value_error: np.ndarray
    first_error: np.ndarray
    second_error: np.ndarray


def local_polynomial(
    t: np.ndarray, y: np.ndarray, sigma: float, window: int, order: int = 3
) -> Smoothed:
    """Fits a polynomial to the `window` samples around each sample.

    At the ends the window stays full and the sample lies at its side: the errors grow there. A gap
    is an end: no window reaches across it. In a stretch with too few samples for a polynomial the
    value is the sample itself, and the derivatives are 0 with infinite errors.

    Args:
        t: (n,) rising times [s]; they need not be uniform.
        y: (n,) values.
        sigma: standard deviation of y's noise, in y's unit.
        window: number of samples in a window; cut to those of the stretch where it is larger.
        order: of the polynomial, 2 or more.

    Returns:
        Value, first and second derivative at each sample [unit, unit/s, unit/s^2] and the
        standard error of each.

    Raises:
        ValueError: the window holds too few samples for the order.
    """
    t, y = np.asarray(t, dtype=float), np.asarray(y, dtype=float)
    parts = stretches(t)
    window = min(window, max(part.stop - part.start for part in parts))
    if order < 2 or window <= order:
        raise ValueError(
            f"A local polynomial needs an order of 2 or more and more samples than its order, "
            f"but the order is {order} and the window has {window} samples."
        )
    fits = [_of_stretch(t[part], y[part], sigma, window, order) for part in parts]
    return Smoothed(*(np.concatenate(each) for each in zip(*fits, strict=True)))


def _of_stretch(t: np.ndarray, y: np.ndarray, sigma: float, window: int, order: int) -> Smoothed:
    """Does what `local_polynomial` does, where there is no gap."""
    n = t.size
    if n <= order:
        nothing, unknown = np.zeros(n), np.full(n, np.inf)
        return Smoothed(y, nothing, nothing, np.full(n, float(sigma)), unknown, unknown)
    window = min(window, n)
    tw = sliding_window_view(t, window)
    yw = sliding_window_view(y, window)
    middle = 0.5 * (tw[:, :1] + tw[:, -1:])
    half = 0.5 * (tw[:, -1:] - tw[:, :1])
    # Times from -1 to 1: the normal equations of a low order are then well conditioned.
    powers = np.arange(order + 1)
    design = ((tw - middle) / half)[:, :, None] ** powers
    transposed = design.transpose(0, 2, 1)
    inverse = np.linalg.inv(transposed @ design)
    offset = yw.mean(axis=1, keepdims=True)
    # For the windows' sake each sample far from zero (a ring that winds) is taken less its mean.
    coefficients = inverse @ (transposed @ (yw - offset)[:, :, None])
    rest = yw - offset - (design @ coefficients)[:, :, 0]
    square = (rest**2).sum(axis=1) / max(window - order - 1, 1)
    scale = np.sqrt(np.where(square > LACK * sigma**2, square, sigma**2))

    which = np.clip(np.arange(n) - window // 2, 0, n - window)
    u = ((t - middle[which, 0]) / half[which, 0])[:, None]
    coefficients, inverse, h = coefficients[which, :, 0], inverse[which], half[which, 0]
    results, errors = [], []
    for derivative in range(3):
        row = _monomials(u, powers, derivative) / (h**derivative)[:, None]
        results.append(np.einsum("np,np->n", row, coefficients))
        variance = np.einsum("np,npq,nq->n", row, inverse, row)
        errors.append(scale[which] * np.sqrt(np.maximum(variance, 0.0)))
    return Smoothed(results[0] + offset[which, 0], results[1], results[2], *errors)


LACK = 4.0
"""Mean square that a polynomial leaves, over that of the noise, from which it does not follow the
motion. Of noise alone it is exceeded by three degrees of freedom once in 135 samples."""


class AtRest(NamedTuple):
    """Body at rest, each (n,): whether it is; its mean angle, that angle's and its rate's errors.

    Errors are standard errors; the rate is that of a straight line through the window.
    """

    rests: np.ndarray
    value: np.ndarray
    value_error: np.ndarray
    rate_error: np.ndarray


RESTING = 11.3
"""Sum of squares of slope, curvature and bend, in units of the noise, below which a body rests: 99
per cent of what noise alone makes of the three."""


def at_rest(t: np.ndarray, y: np.ndarray, sigma: float, window: int) -> AtRest:
    """Finds whether readings around each sample show any motion at all.

    A cubic is a poor guess of the rate of a body that stuck: its slope at the middle of a window is
    five times as uncertain as a straight line's, and the window of a fit that starts there would
    give it a push that only explains noise.

    Args:
        t: (n,) rising times [s]. y: (n,) readings. sigma: of their noise, in y's unit.
        window: samples around each; a gap is an end, as in `local_polynomial`.
    """
    parts = [_rest_of_stretch(t[p], y[p], sigma, window) for p in stretches(np.asarray(t))]
    return AtRest(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _rest_of_stretch(t: np.ndarray, y: np.ndarray, sigma: float, window: int) -> AtRest:
    n, window = t.size, min(window, t.size)
    if window < 5:
        unknown = np.full(n, np.inf)
        return AtRest(np.zeros(n, bool), y, unknown, unknown)
    tw, yw = sliding_window_view(t, window), sliding_window_view(y, window)
    half = 0.5 * (tw[:, -1] - tw[:, 0])
    u = (tw - tw.mean(axis=1, keepdims=True)) / half[:, None]
    basis = np.linalg.qr(u[:, :, None] ** np.arange(4))[0]
    mean = yw.mean(axis=1)
    found = np.einsum("nwp,nw->np", basis[:, :, 1:], yw - mean[:, None])
    rests = (found**2).sum(axis=1) < RESTING * sigma**2
    slope_error = sigma / np.sqrt((u**2).sum(axis=1)) / half
    which = np.clip(np.arange(n) - window // 2, 0, n - window)
    error = np.full(n, sigma / np.sqrt(window))
    return AtRest(rests[which], mean[which], error, slope_error[which])


def _monomials(u: np.ndarray, powers: np.ndarray, derivative: int) -> np.ndarray:
    """(n, p) derivatives of u^0 .. u^(p-1)."""
    factor = np.ones(powers.size)
    for i in range(derivative):
        factor = factor * (powers - i)
    return factor * u ** np.maximum(powers - derivative, 0)
