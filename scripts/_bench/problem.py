"""Problem: the preset `bench`, its variations, and the times at which angles are wanted.

A run is given by a row of eleven numbers, NAMES in that order; eps, the slope of the smoothed dry
friction, is the same for both bodies and goes beside it. Every run starts from rest.
"""

from typing import NamedTuple

import numpy as np

#: The ten parameters that are varied and differentiated by, then the drive's frequency.
NAMES = ("k", "A", "B1", "B2", "c1", "M1", "Tv", "Ts1", "Tst", "T0", "omega")
VARIED = NAMES[:10]
#: What is searched for, given B1.
SEARCHED = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")
#: Columns of the sensitivities: parameters, then initial states.
DIRECTIONS = (*VARIED, "phi1(0)", "phi2(0)", "v1(0)", "v2(0)")

#: As in `tp_jax.model.presets`, whose values a test compares.
BENCH = (0.45, 0.18, 1.2e-3, 5.0e-4, 2.2e-3, 5.0e-3, 2.5e-4, 1.25e-2, 2.5e-3, 4.0, 13.09)
#: Section 5.1 of the paper, with the Newton-consistent reaction: the rider never slips.
PAPER = (100.0, np.pi / 6, 20.0, 1.0, 10.0, 3.0, 1.0, 2.0, 0.5, 10.0, 0.5)

EPS = (1.0e3, 5.0e4)  # s: as printed, and the package's default
RATE = 250.0  # Hz


class Scale(NamedTuple):
    """Scale of the computations: everything, or the quick version that the tests run.

    duration [s]; lanes of the sweep; pairs of interleaved timings; draws of the robustness;
    scaling: numbers of lanes; eps [s]; tolerances: ladder, loosest first; cap [s] on one timed
    call; budget [s] for more readings than `pairs` where calls are short; reference: tolerance of
    the references; runs, recording [s], starts: of the identification; simplices, iterations: of
    Nelder-Mead.
    """

    duration: float = 10.0
    lanes: int = 256
    pairs: int = 5
    draws: int = 10_000
    scaling: tuple[int, ...] = (64, 256, 1024, 4096, 16384)
    eps: tuple[float, ...] = EPS
    tolerances: tuple[float, ...] = tuple(10.0 ** (-n / 2) for n in range(6, 23))
    cap: float = 20.0
    budget: float = 60.0
    reference: float = 1e-12
    runs: int = 6
    recording: float = 10.0
    starts: int = 16
    simplices: int = 64
    iterations: int = 50  # as in Listing 1 of the paper

    @property
    def ts(self) -> np.ndarray:
        """Times of the samples [s]."""
        return times(self.duration)


QUICK = Scale(
    duration=0.4,
    lanes=4,
    pairs=1,
    draws=4,
    scaling=(2,),
    eps=(1.0e3,),
    tolerances=(1e-6, 1e-8),
    budget=0.0,
    runs=2,
    recording=4.0,
    starts=2,
    simplices=2,
    iterations=3,
)


def times(duration: float) -> np.ndarray:
    """Samples at `RATE`, both ends included: 2501 of them in 10 s."""
    return np.linspace(0.0, duration, round(duration * RATE) + 1)


def bench(**changes: float) -> np.ndarray:
    """The preset's row (11,), some of its numbers multiplied: `bench(B2=0.01)`."""
    return np.array([v * changes.get(name, 1.0) for name, v in zip(NAMES, BENCH, strict=True)])


def sweep(lanes: int, spread: float = 0.2, seed: int = 0) -> np.ndarray:
    """Rows (lanes, 11): the ten parameters uniformly within ± spread of the preset, seeded."""
    factors = 1.0 + spread * np.random.default_rng(seed).uniform(-1.0, 1.0, (lanes, len(VARIED)))
    return bench() * np.hstack([factors, np.ones((lanes, 1))])


def anywhere(draws: int, seed: int = 0) -> np.ndarray:
    """Rows (draws, 11) anywhere in the package's bounds; the drive's frequency is the preset's.

    B1 in its own bounds, the others in those of a rig of that B1. Logarithmically, over seven
    decades below an upper bound where the lower one is zero: torques that were all near their
    bounds would all make the same stuck pendulum.
    """
    from tp_jax.model.parameters import BY_NAME

    def between(lower: float, upper: float, fraction: float) -> float:
        lower = lower or 1e-7 * upper
        return lower * (upper / lower) ** fraction

    rows = np.tile(bench(), (draws, 1))
    place = VARIED.index("B1")
    for row, fractions in zip(
        rows, np.random.default_rng(seed).uniform(size=(draws, len(VARIED))), strict=True
    ):
        B1 = between(BY_NAME["B1"].lower, BY_NAME["B1"].upper, fractions[place])
        for column, name in enumerate(VARIED):
            p = BY_NAME[name].scaled(B1)
            row[column] = B1 if name == "B1" else between(p.lower, p.upper, fractions[column])
    return rows
