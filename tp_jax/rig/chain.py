"""Chain from an angle to the number in a file: bridges, noise, converter, firmware."""

import numpy as np
from numpy.typing import ArrayLike


def measure(
    angles: ArrayLike, rng: np.random.Generator, *, noise: float = 1e-3, bits: int = 16
) -> np.ndarray:
    """Readings of angles by two bridges, whose voltages are noisy and converted to whole numbers.

    The bridges of a sensor give sin 2 phi and cos 2 phi of full scale. Each voltage gets white
    noise, is clipped to full scale and rounded to one of 2^bits numbers; the firmware takes the
    angle from both and counts the half turns.

    Args:
        angles: any shape [rad], what ideal sensors would report.
        rng: source of the noise.
        noise: standard deviation of a reading [rad]; 0: none.
        bits: of the converter.
    """
    phi = np.asarray(angles, dtype=float)
    # d(2 phi) of noise across the circle of both voltages is twice that of the angle
    sd = 2.0 * noise
    sine = _convert(np.sin(2.0 * phi) + sd * rng.standard_normal(phi.shape), bits)
    cosine = _convert(np.cos(2.0 * phi) + sd * rng.standard_normal(phi.shape), bits)
    half = 0.5 * np.arctan2(sine, cosine)
    return half + np.pi * np.round((phi - half) / np.pi)


def _convert(voltage: np.ndarray, bits: int) -> np.ndarray:
    """Rounded to the converter's numbers; a tenth of its range is left for noise."""
    step = 2.0 * 1.1 / 2**bits
    return step * np.round(np.clip(voltage, -1.1, 1.1) / step)
