"""Campaigns of a rig that is as the model has it, read by sensors of many kinds."""

import functools
from pathlib import Path

import numpy as np
from scipy import signal

from tp_jax.recordings import Campaign, Recording
from tp_jax.rig import BENCH, VirtualRig

DURATION = 8.0
RUNS = (None, 9.0, 13.0, 17.0)  # rad/s; the first is a decay


def first_order(rng: np.random.Generator, shape: tuple[int, int], rho: float) -> np.ndarray:
    """Noise of unit variance, neighbouring samples of a column correlated by rho."""
    e = rng.standard_normal((shape[0] + 2000, shape[1]))
    return signal.lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], e, axis=0)[2000:]


def moving_average(rng: np.random.Generator, shape: tuple[int, int], theta: float) -> np.ndarray:
    """Noise of unit variance, each error in part that of the sample before."""
    e = rng.standard_normal((shape[0] + 1, shape[1]))
    return (e[1:] + theta * e[:-1]) / np.sqrt(1.0 + theta**2)


def rounded(y: np.ndarray, bits: int) -> np.ndarray:
    """Readings of an encoder with so many bits a turn."""
    step = 2.0 * np.pi / 2**bits
    return step * np.round(y / step)


def slow(rng, y, run):
    """A third of the variance in noise slower than a tenth of a second."""
    white = np.sqrt(0.7) * rng.standard_normal(y.shape)
    return y + 1e-3 * (np.sqrt(0.3) * first_order(rng, y.shape, 0.97) + white)


def coarse(rng, y, run):
    """Coloured, and hidden in part by an encoder's steps."""
    return rounded(y + 3e-4 * first_order(rng, y.shape, 0.8), 12)


def anticorrelated(rng, y, run):
    """Differences of neighbours are larger than of white noise."""
    return y + 1e-3 * moving_average(rng, y.shape, -0.4)


def white(rng, y, run):
    """White noise of a milliradian."""
    return y + 1e-3 * rng.standard_normal(y.shape)


def louder(rng, y, run):
    """White, twice as much in two of the recordings."""
    return y + (2e-3 if run < 2 else 1e-3) * rng.standard_normal(y.shape)


@functools.cache
def motion(omega: float | None, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of a run without noise."""
    t = np.arange(round(DURATION * rate) + 1) / rate
    release = None if omega else 0.9
    return t, VirtualRig(BENCH).run(t, omega=omega, release=release, duration=DURATION)


def campaign(noise, seed: int, rates: tuple[float, ...]) -> Campaign:
    """Runs with nothing hidden.

    Args:
        noise: `noise(rng, y, run)` reads angles y (n, 2). seed: of it. rates: of each run [Hz].
    """
    rng = np.random.default_rng(seed)
    recordings = []
    for i, (omega, rate) in enumerate(zip(RUNS, rates, strict=True)):
        t, y = motion(omega, rate)
        y = noise(rng, y, i)
        name = f"run-{omega or 0.0:.0f}.csv"
        recordings.append(
            Recording(
                name=name,
                label=name,
                file=Path(name),
                t=t,
                phi1=y[:, 0],
                phi2=y[:, 1],
                drive=None,
                forced=omega is not None,
                omega=omega,
                span=None,
                start=None,
                repeat=None,
                held_out=False,
                sha256="",
            )
        )
    return Campaign(
        name="noisy",
        model="double",
        B1=BENCH.B1,
        B2=None,
        k=None,
        sample_rate=None,
        recordings=tuple(recordings),
        folder=Path(),
    )
