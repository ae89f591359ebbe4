"""Small problems of estimation whose answers are known: the bench, integrated by the reference."""

import dataclasses
import functools
from pathlib import Path

import numpy as np

from tests.reference import BENCH, reference
from tp_jax.effects import catalogue
from tp_jax.estimation.layout import Layout, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.windows import Prepared, Windows, cut
from tp_jax.recordings import Campaign, Recording

RATE = 250.0
DURATION = 2.0
OMEGAS = (13.09, 8.0)
CAPACITY = 1024
"""Samples in a lane, as of most campaigns: the compiled programs are then those of other tests."""


def numbers(recording: int) -> dict[str, float]:
    """What the reference needs for one of the recordings."""
    return BENCH | dict(omega=OMEGAS[recording], middle=0.5 * DURATION, drift=1.0 / DURATION)


@functools.cache
def truth(recording: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and motion (n, 4) of a recording, from rest."""
    ts = np.arange(round(DURATION * RATE) + 1) / RATE
    return ts, reference(numbers(recording), ts, rtol=1e-12, atol=1e-13)


def prepared(recording: int) -> Prepared:
    """A recording without noise whose smoothed readings are its true states."""
    ts, y = truth(recording)
    both = np.array([True, True])
    return Prepared(ts, y[:, :2], both, y, np.ones_like(y), None)


def choose(windows: Windows, which) -> Windows:
    """Some of the windows, in the order given."""
    w = np.asarray(which)
    return Windows(windows.recording[w], windows.first[w], windows.count[w], windows.horizon)


@functools.cache
def whole_layout() -> Layout:
    """The whole catalogue: the same programs for all tests that use it."""
    return Layout("double", tuple(catalogue().values()))


def bench_problem(horizon: float, which=None) -> Problem:
    """Both recordings in windows (some of them), residuals in rad."""
    recordings = tuple(prepared(r) for r in range(len(OMEGAS)))
    windows = cut(recordings, horizon)
    if which is not None:
        windows = choose(windows, which)
    return Problem(
        layout=whole_layout(),
        prepared=recordings,
        windows=windows,
        capacity=CAPACITY,
        B1=BENCH["B1"],
    )


def bench_values() -> Values:
    """The true numbers of both recordings."""
    same = {n: v for n, v in BENCH.items() if n not in ("eps", "omega")}
    n = len(OMEGAS)
    return Values.build(
        whole_layout(),
        n,
        same
        | dict(
            eps1=BENCH["eps"],
            eps2=BENCH["eps"],
            omega=OMEGAS,
            running=1.0,
            drift_middle=0.5 * DURATION,
            drift_rate=1.0 / DURATION,
        ),
    )


def lossy(recording: Recording, seed: int, *lost: tuple[float, float]) -> Recording:
    """A recording without the samples between the times given [s], and one in a hundred more."""
    t = recording.t
    kept = np.random.default_rng(seed).random(t.size) > 0.01
    for t0, t1 in lost:
        kept &= (t < t0) | (t > t1)
    return dataclasses.replace(
        recording, t=t[kept], phi1=recording.phi1[kept], phi2=recording.phi2[kept]
    )


def synthetic_campaign(
    noise: float = 1e-3,
    duration: float = 3.0,
    seed: int = 0,
    effect: str = "",
    hidden: dict[str, float] | None = None,
    **other: float,
) -> Campaign:
    """A decay and two forced recordings of the bench (or other numbers), with white noise.

    Args:
        noise: [rad]. duration: [s]. seed: of the noise.
        effect, hidden: one of `reference.FORMULAS` with its numbers, which is in the rig.
        other: numbers of the bench that differ.
    """
    rng = np.random.default_rng(seed)
    ts = np.arange(round(duration * RATE) + 1) / RATE
    recordings = []
    for omega in (None, 13.09, 17.0):
        driven = omega is not None
        p = BENCH | other | (dict(omega=omega) if driven else dict(A=0.0))
        y0 = np.zeros(4) if driven else np.array([1.2, 0.0, 0.0, 0.0])
        y = reference(p, ts, y0, effect, hidden)[:, :2] + noise * rng.standard_normal((ts.size, 2))
        name = f"run-{omega:.0f}.csv" if driven else "decay.csv"
        recordings.append(
            Recording(
                name=name,
                label=name,
                file=Path(name),
                t=ts,
                phi1=y[:, 0],
                phi2=y[:, 1],
                drive=None,
                forced=driven,
                omega=omega,
                span=None,
                start=None,
                repeat=None,
                held_out=False,
                sha256="",
            )
        )
    return Campaign(
        name="synthetic",
        model="double",
        B1=BENCH["B1"],
        B2=None,
        k=None,
        sample_rate=RATE,
        recordings=tuple(recordings),
        folder=Path(),
    )


def synthetic_values(setting: PreparedCampaign) -> Values:
    """What made the synthetic campaign."""
    same = {n: v for n, v in BENCH.items() if n not in ("omega", "eps")}
    more = dict(eps1=BENCH["eps"], eps2=BENCH["eps"], phase=0.0, zero1=0.0)
    return initial_values(setting).replace(same | more)
