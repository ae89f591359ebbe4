"""Recorder of a rig: sensors with coloured noise, a coarse converter, perhaps a drive's angle.

A reading of an angle is quantised(angle + zero + white + coloured noise). The coloured part is an
autoregression of second order at the sampling rate, x[i] = ar1 x[i-1] + ar2 x[i-2] + e[i].
"""

import dataclasses
import math

import numpy as np
from scipy import signal

from tp_jax.errors import InputError

SETTLED = 200  # samples after which an autoregression has forgotten its start


@dataclasses.dataclass(frozen=True)
class Sensor:
    """Sensor of one body.

    Attributes:
        white, coloured: standard deviations of both parts of the noise [rad].
        ar: of the coloured part, stationary.
        bits: of the converter, whose numbers are spread over one turn.
        zero: reading at the true zero [rad].
    """

    white: float
    coloured: float = 0.0
    ar: tuple[float, float] = (0.0, 0.0)
    bits: int = 16
    zero: float = 0.0

    def __post_init__(self):
        one, two = self.ar
        if not (abs(two) < 1.0 and abs(one) < 1.0 - two):
            raise InputError(f"Noise with the coefficients {one:g}, {two:g} is not stationary.")

    @property
    def step(self) -> float:
        """Step between two numbers of the converter [rad]."""
        return 2.0 * math.pi / 2**self.bits

    @property
    def rms(self) -> float:
        """Root mean square of all noise, rounding included [rad]."""
        return math.sqrt(self.white**2 + self.coloured**2 + self.step**2 / 12.0)

    @property
    def lag_one(self) -> float:
        """Autocorrelation of all noise, without rounding, from one sample to the next."""
        own = self.ar[0] / (1.0 - self.ar[1])
        return own * self.coloured**2 / max(self.white**2 + self.coloured**2, 1e-300)

    @property
    def slow(self) -> float:
        """Rms of white noise with the spectral density that this has at frequency zero [rad].

        What matters for motions that are slow against the sampling. Rounding counts as white.
        """
        one, two = self.ar
        # variance of an AR(2) of unit innovations, over which its density at zero is taken
        variance = (1.0 - two) / ((1.0 + two) * ((1.0 - two) ** 2 - one**2))
        density = 1.0 / (1.0 - one - two) ** 2 / variance
        parts = self.white**2 + self.coloured**2 * density + self.step**2 / 12.0
        return math.sqrt(parts)

    def read(self, angle: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Readings (n,) [rad] of an angle sampled at equal distances."""
        x = angle + self.zero + self.white * rng.standard_normal(angle.size)
        if self.coloured > 0.0:
            e = rng.standard_normal(angle.size + SETTLED)
            y = np.asarray(signal.lfilter([1.0], [1.0, -self.ar[0], -self.ar[1]], e))[SETTLED:]
            one, two = self.ar
            variance = (1.0 - two) / ((1.0 + two) * ((1.0 - two) ** 2 - one**2))
            x = x + self.coloured / math.sqrt(variance) * y
        return rounded(x, self.step)


@dataclasses.dataclass(frozen=True)
class DriveSensor:
    """Sensor of the motor's arm: reading = gain f + offset, with white noise, rounded.

    Attributes:
        gain: [reading per rad]. offset: of the reading.
        noise: standard deviation [rad of the arm]. bits: of the converter.
    """

    gain: float
    offset: float
    noise: float
    bits: int

    def read(self, angle: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Readings (n,) of the arm's angle [rad]."""
        x = angle + self.noise * rng.standard_normal(angle.size)
        return self.gain * rounded(x, 2.0 * math.pi / 2**self.bits) + self.offset


@dataclasses.dataclass(frozen=True)
class Recorder:
    """All that lies between a rig and its files.

    Attributes:
        rate: samples a second. sensor1, sensor2: of phi1 and phi2.
        drive: None where the drive is commanded and its angle not recorded.
        decays_metered: where the drive is measured, its column is used in decays as well.
        with_B1, with_B2: whether the campaign gives these moments of inertia.
    """

    rate: float
    sensor1: Sensor
    sensor2: Sensor
    drive: DriveSensor | None = None
    decays_metered: bool = False
    with_B1: bool = True
    with_B2: bool = False


def rounded(x: np.ndarray, step: float) -> np.ndarray:
    """Rounds to whole numbers of steps."""
    return step * np.round(x / step)
