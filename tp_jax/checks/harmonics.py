"""Motion at a frequency and its harmonics, by least squares."""

from typing import NamedTuple

import numpy as np


class Fit(NamedTuple):
    """Part of a motion that is at a frequency and its harmonics.

    Attributes:
        share: of the variance, 0 to 1; a straight line is taken off before.
        amplitude: complex, of the fundamental, x = Re(amplitude exp(i omega t)).
    """

    share: float
    amplitude: complex


def fit(t: np.ndarray, x: np.ndarray, omega: float, harmonics: int = 3) -> Fit:
    """Fits a straight line and harmonics of omega [rad/s] to (n,) samples x at times t [s]."""
    u = t - t[0]
    wave = np.exp(1j * omega * u)
    powers = [wave ** (k + 1) for k in range(harmonics)]
    straight = [np.ones_like(u), (u - u.mean()) / (u[-1] or 1.0)]
    design = np.column_stack(straight + [f for p in powers for f in (p.real, p.imag)])
    # the normal equations: many times as fast as lstsq, and the columns are nearly orthogonal
    gram, right = design.T @ design, design.T @ x
    solution = np.linalg.lstsq(gram, right, rcond=None)[0]
    offset = np.linalg.lstsq(gram[:2, :2], right[:2], rcond=None)[0]
    whole = float(np.sum((x - design[:, :2] @ offset) ** 2))
    left = float(np.sum((x - design @ solution) ** 2))
    share = 1.0 - left / whole if whole > 0.0 else 0.0
    # from the first sample's clock to that of t, so that two channels compare
    amplitude = complex(solution[2], -solution[3]) * np.exp(-1j * omega * t[0])
    return Fit(share, amplitude)


def strongest(t: np.ndarray, x: np.ndarray) -> float:
    """Frequency [rad/s] of the strongest swing of (n,) samples x at times t [s]."""
    n = t.size
    even = np.linspace(t[0], t[-1], n)
    y = np.interp(even, t, x - x.mean()) * np.hanning(n)
    power = np.abs(np.fft.rfft(y, 8 * n)) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(8 * n, (t[-1] - t[0]) / (n - 1))
    # slower than twice in a run: a drift
    return float(frequency[np.argmax(np.where(frequency * (t[-1] - t[0]) < 12.0, 0.0, power))])


def refined(t: np.ndarray, x: np.ndarray, omega: float, harmonics: int = 3) -> float:
    """The frequency [rad/s] near omega that holds most of a steady motion.

    A tenth of a radian of phase in ten seconds matters to a fit, and is a hundredth of a rad/s.
    """
    width = np.pi / float(t[-1] - t[0])  # half of what a spectrum tells apart
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    low, high = omega - width, omega + width
    for _ in range(30):
        a, b = high - golden * (high - low), low + golden * (high - low)
        if fit(t, x, a, harmonics).share > fit(t, x, b, harmonics).share:
            high = b
        else:
            low = a
    return 0.5 * (low + high)


def spectrum(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and amplitudes, in x's unit, of (n,) samples x at times t [s]."""
    n = t.size
    even = np.linspace(t[0], t[-1], n)
    window = np.hanning(n)
    y = np.interp(even, t, x - x.mean()) * window
    frequency = 2.0 * np.pi * np.fft.rfftfreq(n, (t[-1] - t[0]) / (n - 1))
    return frequency, 2.0 * np.abs(np.fft.rfft(y)) / window.sum()


def end_of(t: np.ndarray, part: float) -> slice:
    """The samples in the last `part` of the time."""
    return slice(int(np.searchsorted(t, t[-1] - part * (t[-1] - t[0]))), t.size)
