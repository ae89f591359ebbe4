"""Rough rigs: how they are recorded, and which numbers they have, drawn case by case."""

import dataclasses
import math

import numpy as np

from tp_jax.rig import BENCH, RigParameters
from trials.recorder import DriveSensor, Recorder, Sensor
from trials.truth import TORQUES

Range = tuple[float, float]

RIDER = ("B2", "Tv", "Ts1", "Tst", "T0")
RINGING = 0.5  # damping ratio up to which a column swings at all
LOOSE = 0.5  # of the spring's largest torque: a bearing with more dry friction hardly moves
ATTEMPTS = 2000  # parameters drawn until a rig is plausible; one in ten or so is


@dataclasses.dataclass(frozen=True)
class RoughSettings:
    """Ranges that rough rigs are drawn from; pairs are ends, "log" uniform in the logarithm.

    Attributes:
        rates: samples a second, log. recordings: of a campaign. durations: of one [s], log.
        most_samples: of a campaign, its runs being shortened for that; most_time: [s], likewise,
            for a case is to be made in seconds.
        least_per_period: samples in a period of the column alone; with fewer nobody would record.
        single: share of rigs without a rider. decays_only: without a driven run.
        measured: of those driven, whose drive is measured; decays_metered: of these, whose decays
            are recorded with the drive's column too.
        without_B1: share of campaigns that give no moment of inertia; with_B2: of the others
            (with a rider) that give both.
        noise: standard deviation without rounding [rad], log. white_only: share of sensors whose
            noise is white; else coloured: share of its variance; lag_one: autocorrelation of the
            coloured part from sample to sample. second: share of these that are AR(2), with
            curvature as the ends of its second coefficient.
        bits: of a converter over a turn. zero: of either sensor, either sign at most [rad].
        spread: factor either way about the bench's of every number, log. torque: of all together.
        swing: factor on the amplitude of a run whose drive is measured.
        drive_noise: of the drive's sensor, part of the amplitude, log. drive_bits: of it.
        gain: of it, either sign [reading per rad], log. offset: either sign at most.
        releases: of decays, either sign [rad].
        sealed_runs: never given; sealed_longest: [s].
        periods: of the rig, in a window in which its detectable sizes are measured; looked_at:
            runs for that at most, of looked_for [s] together, per_run windows in each. They are
            few, for that is what takes time.
    """

    rates: Range = (50.0, 1000.0)
    recordings: tuple[int, int] = (2, 12)
    durations: Range = (3.0, 60.0)
    most_samples: int = 60_000
    most_time: float = 200.0
    least_per_period: float = 10.0
    single: float = 0.25
    decays_only: float = 0.1
    measured: float = 0.25
    decays_metered: float = 0.5
    without_B1: float = 0.5
    with_B2: float = 0.5
    noise: Range = (2e-4, 3e-3)
    white_only: float = 0.3
    coloured: Range = (0.2, 1.0)
    lag_one: Range = (0.0, 0.8)
    second: float = 0.5
    curvature: Range = (-0.5, 0.3)
    bits: tuple[int, int] = (10, 16)
    zero: float = 0.04
    spread: float = math.sqrt(10.0)
    torque: Range = (1e-2, 1e2)
    swing: Range = (0.6, 1.4)
    drive_noise: Range = (1e-3, 2e-2)
    drive_bits: tuple[int, int] = (10, 16)
    gain: Range = (0.1, 10.0)
    offset: float = 3.0
    releases: Range = (0.2, 1.2)
    sealed_runs: int = 3
    sealed_longest: float = 20.0
    periods: float = 1.5
    looked_at: int = 3
    looked_for: float = 25.0
    per_run: int = 3


@dataclasses.dataclass(frozen=True)
class Kind:
    """Kind of a rig before its numbers: rate [Hz], runs, with a rider, driven, measured drive."""

    rate: float
    runs: int
    rider: bool
    driven: bool
    measured: bool


def draw_kind(rng: np.random.Generator, settings: RoughSettings) -> Kind:
    """Kind of a rig and its campaign."""
    rate = float(f"{between(rng, settings.rates):.3g}")  # as people set them
    runs = int(rng.integers(settings.recordings[0], settings.recordings[1] + 1))
    rider, driven = (
        bool(rng.random() >= share) for share in (settings.single, settings.decays_only)
    )
    measured = driven and bool(rng.random() < settings.measured)
    return Kind(rate, runs, rider, driven, measured)


def draw_parameters(rng: np.random.Generator, settings: RoughSettings, kind: Kind) -> RigParameters:
    """Numbers of a rig that swings, is not held by its bearing, and not too fast for its rate."""
    low, high = 1.0 / settings.spread, settings.spread
    for _ in range(ATTEMPTS):
        numbers = {
            name: value * between(rng, (low, high))
            for name, value in dataclasses.asdict(BENCH).items()
        }
        if not kind.rider:
            numbers |= dict.fromkeys(RIDER, 0.0)
        damping = numbers["c1"] / (2.0 * math.sqrt(numbers["k"] * (numbers["B1"] + numbers["B2"])))
        fastest = math.sqrt(numbers["k"] / numbers["B1"]) / (2.0 * math.pi)
        reach = numbers["A"] if kind.driven else settings.releases[0]
        if (
            damping < RINGING
            and numbers["M1"] < LOOSE * numbers["k"] * reach
            and kind.rate > settings.least_per_period * fastest
        ):
            scale = between(rng, settings.torque)
            return RigParameters(
                **{name: x * (scale if name in TORQUES else 1.0) for name, x in numbers.items()}
            )
    raise RuntimeError(f"None of {ATTEMPTS} rigs was plausible.")


def draw_recorder(
    rng: np.random.Generator, settings: RoughSettings, kind: Kind, A: float
) -> Recorder:
    """Draws how a rig whose drive has the amplitude A [rad] is recorded."""
    drive = None
    sensor1, sensor2 = _sensor(rng, settings), _sensor(rng, settings)
    if kind.measured:
        drive = DriveSensor(
            gain=between(rng, settings.gain) * float(rng.choice((-1.0, 1.0))),
            offset=float(rng.uniform(-settings.offset, settings.offset)),
            noise=A * between(rng, settings.drive_noise),
            bits=_whole(rng, settings.drive_bits),
        )
    metered = bool(rng.random() < settings.decays_metered)
    with_B1 = bool(rng.random() >= settings.without_B1)
    with_B2 = bool(rng.random() < settings.with_B2) and with_B1 and kind.rider
    return Recorder(
        kind.rate, sensor1, sensor2, drive, metered and drive is not None, with_B1, with_B2
    )


def _sensor(rng: np.random.Generator, settings: RoughSettings) -> Sensor:
    noise, bits = between(rng, settings.noise), _whole(rng, settings.bits)
    zero = float(rng.uniform(-settings.zero, settings.zero))
    share = 0.0 if rng.random() < settings.white_only else float(rng.uniform(*settings.coloured))
    lag, two = float(rng.uniform(*settings.lag_one)), 0.0
    if rng.random() < settings.second:
        two = float(rng.uniform(*settings.curvature))
    # autocorrelation of an AR(2) at lag one: ar1 / (1 - ar2)
    ar = (lag * (1.0 - two), two)
    return Sensor(noise * math.sqrt(1.0 - share), noise * math.sqrt(share), ar, bits, zero)


def between(rng: np.random.Generator, ends: Range) -> float:
    """A number uniform in its logarithm."""
    return math.exp(rng.uniform(math.log(ends[0]), math.log(ends[1])))


def _whole(rng: np.random.Generator, ends: tuple[int, int]) -> int:
    return int(rng.integers(ends[0], ends[1] + 1))
