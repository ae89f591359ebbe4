"""A measured drive without the noise of its sensor, where it is periodic but for that noise.

A model takes a measured drive as it reads, and the spring turns the noise of the readings into a
torque on the column: one that the rig never felt, slow enough to move it, and no effect's. A motor
that turns a crank moves periodically. Where a constant and some harmonics of one frequency leave
nothing but noise of the size that the readings have, they are the drive, and are known far better
than any reading. Where they leave more (a drive by hand, a motor whose speed wanders), the readings
stay as they are.

Source: Quinn and Fernandes (1991), Biometrika 78, 489-497, for a frequency found by least squares.
"""

import dataclasses

import numpy as np
from scipy.optimize import minimize_scalar

from tp_jax.recordings.noise import noise_level_and_error, quantum, steps_hide
from tp_jax.recordings.recording import Recording


@dataclasses.dataclass(frozen=True)
class DrivePolicy:
    """Conditions under which a measured drive is taken for its periodic part.

    Attributes:
        noise: of the readings, of the drive's amplitude, below which it does not matter. The spring
            turns it into a torque, which moves a column of 10 rad/s, read 200 times a second, by a
            tenth of it in half a second.
        harmonics: at most.
        errors: standard errors by which what is left may exceed the noise.
        chance: that noise has a line as high as is taken for one.
        slow: multiples of the drive's frequency up to which what is left must be white: the
            column's inertia lets through nothing faster. Rounding has lines beyond.
        steps: of the readings, which what all harmonics leave may reach where they hide the noise.
            Rounding then goes with the motion, and has lines. It leaves half a step, and little
            noise turns a reading over by another half.
        samples: below which nothing is said.
    """

    noise: float = 1e-3
    harmonics: int = 8
    errors: float = 3.0
    chance: float = 1e-3
    slow: float = 8.0
    steps: float = 1.25
    samples: int = 64


POLICY = DrivePolicy()

SEARCHED = 2048
"""Samples from which a frequency is sought, where so many show it."""


@dataclasses.dataclass(frozen=True)
class PeriodicDrive:
    """A measured drive but for its noise.

    Attributes:
        values: (n,) at the samples, in the readings' unit.
        omega: its frequency [rad/s]; 0 where it stands.
        harmonics: how many it has.
        noise: of the readings, as a part of the amplitude of the drive.
        errors: (n, q) changes of the values by one standard error of q independent numbers each:
            combinations of the constant, the harmonics and the frequency.
    """

    values: np.ndarray
    omega: float
    harmonics: int
    noise: float
    errors: np.ndarray

    def moved(self, numbers: np.ndarray) -> "PeriodicDrive":
        """The drive with its numbers (q,) moved by standard errors."""
        return dataclasses.replace(self, values=self.values + self.errors @ numbers)


def relative_noise(recording: Recording) -> float:
    """Noise of a measured drive as a part of its amplitude; 0 where none is measured, or moves."""
    if recording.drive is None or np.ptp(recording.drive) == 0.0:
        return 0.0
    level = noise_level_and_error(recording.t, recording.drive)[0]
    return float(level / (np.sqrt(2.0) * recording.drive.std()))


def periodic(recording: Recording, policy: DrivePolicy = POLICY) -> PeriodicDrive | None:
    """Finds what a measured drive is but for noise.

    Args:
        recording: with or without a measured drive. policy: what decides.

    Returns:
        None where there is no measured drive, where its noise does not matter, or where more than
        noise would be left.
    """
    t, y = recording.t, recording.drive
    if y is None or t.size < policy.samples or np.ptp(y) == 0.0:
        return None
    noise = relative_noise(recording)
    if noise <= policy.noise:
        return None
    level, error = noise_level_and_error(t, y)
    middle = t - t.mean()
    constant = np.full(t.size, y.mean())
    coarse = steps_hide(y, level)
    # on the edge between two steps the readings of a motor at rest jump by half of one
    still = max(level, 0.5 * quantum(y)) if coarse else level
    if _is_noise(t, y - constant, 1, still, error, 0.0, policy):
        return PeriodicDrive(constant, 0.0, 0, noise, np.full((t.size, 1), still / t.size**0.5))
    first = _frequency(t, y)
    most = min(policy.harmonics, int(0.4 * np.pi / np.median(np.diff(t)) / first))
    if most < 1:
        return None
    # all harmonics at first: where they leave too much, fewer leave more, and the search is over
    omega = _best_frequency(middle, y, first, most)
    enough = most
    for harmonics in (most, *range(1, most)):
        values = _values(middle, y, omega, harmonics)
        if _is_noise(t, y - values, 2 * harmonics + 2, level, error, omega, policy):
            if harmonics < most:
                enough = harmonics
                break
        elif harmonics == most and not (coarse and _is_rounding(y, y - values, policy)):
            return None
    values, errors = _values(middle, y, omega, enough), _errors(middle, y, omega, enough)
    size = _repeating(y, level, max(omega * np.ptp(t) / (2.0 * np.pi), 1.0))
    return PeriodicDrive(values, omega, enough, noise, size * errors)


def without_drive_noise(recording: Recording, policy: DrivePolicy = POLICY) -> Recording:
    """The recording with its drive's periodic part in place of the readings, if it has one."""
    found = periodic(recording, policy)
    return recording if found is None else dataclasses.replace(recording, drive=found.values)


def _frequency(t: np.ndarray, y: np.ndarray) -> float:
    """The drive's frequency [rad/s] to a tenth of the resolution of its spectrum."""
    even = np.linspace(t[0], t[-1], t.size)
    swing = np.interp(even, t, y - y.mean()) * np.hanning(t.size)
    power = np.abs(np.fft.rfft(swing, 8 * t.size))
    power[:4] = 0.0
    return float(2.0 * np.pi * np.argmax(power) / (8 * t.size * (even[1] - even[0])))


def _values(t: np.ndarray, y: np.ndarray, omega: float, harmonics: int) -> np.ndarray:
    """Values (n,) of the best constant and harmonics of a frequency."""
    A = _waves(t, omega, harmonics)
    return A @ _best(A, y)


def _errors(t: np.ndarray, y: np.ndarray, omega: float, harmonics: int) -> np.ndarray:
    """Changes (n, 2 h + 2) of those values that noise of a unit makes, the frequency's too."""
    A = _waves(t, omega, harmonics)
    _, even, odd = np.split(_best(A, y), [1, 1 + harmonics])
    order = np.arange(1, harmonics + 1)
    rate = t * (A[:, 1:] @ np.concatenate([order * odd, -order * even]))  # by the frequency
    return np.linalg.qr(np.column_stack([A, rate]))[0]


def _waves(t: np.ndarray, omega: float, harmonics: int) -> np.ndarray:
    """Columns (n, 2 h + 1): one, cosines, sines."""
    angle = omega * np.outer(t, np.arange(1, harmonics + 1))
    return np.concatenate([np.ones((t.size, 1)), np.cos(angle), np.sin(angle)], axis=1)


def _best(A: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Numbers by which columns come closest to readings."""
    return np.linalg.lstsq(A.T @ A, A.T @ y, rcond=1e-12)[0]


def _best_frequency(t: np.ndarray, y: np.ndarray, first: float, harmonics: int) -> float:
    """The frequency near another whose harmonics leave least.

    Means over blocks, of which 32 make a period, have the same; of ten thousands of samples the
    search takes these.
    """
    in_period = 2.0 * np.pi / first * (t.size - 1) / np.ptp(t)
    block = max(1, min(t.size // SEARCHED, int(in_period / 32.0)))
    whole = t.size // block * block
    t, y = (x[:whole].reshape(-1, block).mean(axis=1) for x in (t, y))
    near = np.pi / np.ptp(t)  # half of a period more or less in all
    found = minimize_scalar(
        lambda omega: float(((y - _values(t, y, omega, harmonics)) ** 2).sum()),
        bounds=(max(first - near, 0.2 * first), first + near),
        method="bounded",
        options={"xatol": 1e-6 * near},
    )
    return float(found.x)


def _repeating(y: np.ndarray, level: float, periods: float) -> float:
    """Noise of readings as it counts for what is the same in every period.

    Rounding comes again with each of them, so that more tell no more of it, but for the part that
    other noise has spread: exp(-4 pi^2 s^2 / step^2) of its variance is left of it beside noise of
    standard deviation s.

    Source: Widrow, Kollar and Liu (1996), IEEE Trans. Instrum. Meas. 45, 353-361.
    """
    step = quantum(y)
    if not step:
        return level
    rounding = step**2 / 12.0
    other = max(level**2 - rounding, 0.0)
    again = rounding * np.exp(-4.0 * np.pi**2 * other / step**2)
    return float(np.sqrt(level**2 + (periods - 1.0) * again))


def _is_rounding(y: np.ndarray, left: np.ndarray, policy: DrivePolicy) -> bool:
    """True where no more is left than steps of the readings make."""
    return float(np.abs(left).max()) <= policy.steps * quantum(y)


def _is_noise(
    t: np.ndarray,
    left: np.ndarray,
    numbers: int,
    level: float,
    error: float,
    omega: float,
    policy: DrivePolicy,
) -> bool:
    """True where no more than noise is left, white where the column would answer."""
    n = left.size
    excess = float((left**2).sum()) / max(n - numbers, 1) / level**2 - 1.0
    if excess > policy.errors * np.hypot(2.0 * error, np.sqrt(2.0 / n)):
        return False
    power = np.abs(np.fft.rfft(left))[1:] ** 2 / (n * level**2)  # of white noise: 1 on average
    slow = 2.0 * np.pi * np.arange(1, power.size + 1) / np.ptp(t)
    seen = power[slow <= policy.slow * omega] if omega else power
    if not seen.size:
        return True
    lines = bool(seen.max() > np.log(seen.size / policy.chance))
    return not lines and seen.mean() - 1.0 <= policy.errors * np.hypot(
        2.0 * error, 1.0 / np.sqrt(seen.size)
    )
