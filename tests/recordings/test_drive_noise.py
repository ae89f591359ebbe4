"""The noise of a measured drive goes where the drive is periodic, and only there."""

import numpy as np
import pytest

from tp_jax.recordings import Recording
from tp_jax.recordings.drive_noise import periodic, relative_noise, without_drive_noise

RATE, OMEGA, AMPLITUDE = 200.0, 13.09, 0.4


def of(drive, rate=RATE, t=None):
    t = np.arange(drive.size) / rate if t is None else t
    return Recording.from_arrays(t, np.sin(t), drive=drive, name="run.csv")


def swing(samples=2000, rate=RATE, omega=OMEGA, second=0.0):
    """Readings with a gain and an offset, as counts have them."""
    t = np.arange(samples) / rate
    angle = np.sin(omega * t + 0.3) + second * np.sin(2.0 * omega * t + 1.0)
    return 50.0 * AMPLITUDE * angle + 7.0


def noise(samples, size, seed=0):
    return 50.0 * AMPLITUDE * size * np.random.default_rng(seed).standard_normal(samples)


@pytest.mark.parametrize("size", [2e-2, 2e-3])
@pytest.mark.parametrize("omega", [3.0, 13.09, 40.0])
def test_a_noisy_sine(size, omega):
    true = swing(omega=omega)
    recording = of(true + noise(true.size, size))
    assert relative_noise(recording) == pytest.approx(size, rel=0.1)
    found = periodic(recording)
    assert found.omega == pytest.approx(omega, abs=1e-2)
    assert found.harmonics == 1
    left = (found.values - true).std() / (50.0 * AMPLITUDE * size)
    assert left < 0.1, "known far better than any reading"


def test_a_crank_has_harmonics():
    true = swing(second=0.05)
    found = periodic(of(true + noise(true.size, 0.01)))
    assert found.harmonics == 2
    assert (found.values - true).std() < 0.1 * 50.0 * AMPLITUDE * 0.01


def test_a_motor_that_stands():
    found = periodic(of(noise(1500, 0.01) + 3.0))
    assert (found.omega, found.harmonics) == (0.0, 0)
    assert np.ptp(found.values) == 0.0


def test_few_periods_and_a_coarse_converter():
    """Three periods at 50 samples a second, in 10 bits a turn."""
    t = np.arange(300) / 50.0
    rng = np.random.default_rng(4)
    angle, step = AMPLITUDE * np.sin(3.3 * t), 2.0 * np.pi / 1024
    read = step * np.round((angle + 4e-3 * rng.standard_normal(t.size)) / step)
    found = periodic(of(read, t=t))
    assert (found.values - angle).std() < 1.5e-3


@pytest.mark.parametrize(
    "drive",
    [
        lambda t: np.sin(OMEGA * t + 0.05 * t**2),  # its speed rises
        lambda t: np.sin(OMEGA * t) * (1.0 + 0.05 * np.sin(0.7 * t)),  # its amplitude wanders
        lambda t: np.clip(4.0 * t - 8.0, 0.0, 1.0),  # turned once, by hand
        lambda t: np.sin(OMEGA * t) + 0.02 * (t > 5.0),  # slips
    ],
)
def test_what_is_not_periodic_stays_as_it_reads(drive):
    t = np.arange(2000) / RATE
    recording = of(20.0 * drive(t) + noise(t.size, 0.005), t=t)
    assert periodic(recording) is None
    assert without_drive_noise(recording) is recording


def test_noise_that_does_not_matter_stays():
    true = swing()
    recording = of(true + noise(true.size, 1e-4))
    assert relative_noise(recording) == pytest.approx(1e-4, rel=0.2)
    assert relative_noise(of(np.full(2000, 0.1))) == 0.0
    assert without_drive_noise(recording) is recording


def test_a_commanded_drive():
    t = np.arange(500) / RATE
    recording = Recording.from_arrays(t, np.sin(t), omega=13.0)
    assert relative_noise(recording) == 0.0
    assert without_drive_noise(recording) is recording


def test_most_noisy_sines_are_found():
    """Noise is refused as noise once in a hundred times."""
    found = 0
    for seed in range(200):
        true = swing(samples=800, omega=5.0 + 0.05 * seed)
        found += periodic(of(true + noise(true.size, 0.01, seed))) is not None
    assert found >= 194


def test_a_coarse_reading_of_a_motor_that_stands():
    """On the edge between two steps the readings jump by half a step about their mean."""
    step = 0.5
    rng = np.random.default_rng(2)
    read = step * np.round((0.5 * step + 0.1 * step * rng.standard_normal(4000)) / step)
    found = periodic(of(read))
    assert found.harmonics == 0
    assert np.ptp(found.values) == 0.0


@pytest.mark.parametrize("second", [0.0, 0.02])
def test_rounding_that_goes_with_the_motion(second):
    """Hardly any noise: the steps' error repeats; a harmonic below a step is not lost for it."""
    true = swing(samples=8000, omega=16.44, second=second)
    step = 0.03 * 50.0 * AMPLITUDE
    read = step * np.round((true + 0.02 * step * noise(true.size, 1.0)) / step)
    found = periodic(of(read))
    assert (found.values - true).std() < 0.25 * (read - true).std()


@pytest.mark.parametrize("size", [0.7, 1.2])
def test_a_coarse_reading_of_a_motor_that_turns_a_little(size):
    """It moves by a step or so, which is no noise."""
    true = size * np.sin(11.0 * np.arange(4000) / RATE)
    found = periodic(of(np.round(true)))
    assert found is None or np.ptp(found.values) > size


@pytest.mark.parametrize("steps", [2.0, 3.0])
def test_a_coarse_reading_of_a_motor_that_creeps(steps):
    true = np.linspace(0.0, steps, 4000)
    found = periodic(of(np.round(true)))
    assert found is None or np.abs(found.values - true).max() < 0.6, "half a step, as it reads"
