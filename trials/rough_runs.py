"""Runs that a rough rig makes: those given, and sealed ones of other excitation."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from tp_jax.rig import RigParameters, VirtualRig
from tp_jax.rig.plan import HIGHEST, LOWEST, SLIDES
from trials.draw import FARTHEST, MOVES
from trials.recorded import begin
from trials.rough import Kind, RoughSettings, between

Run = dict[str, float]

LOUD = 20.0  # times its noise: a column that swings so far is seen to swing
SLIDING = 1 / 3  # of the runs, at least, must show the rider
PERIODS, AT_LEAST = 12.0, 3.0  # of the rig, and s: as long as a run is watched
PACE = 1 / 24  # of a period, between looks
BEYOND = 0.05, 0.15  # by which sealed frequencies and releases lie outside those given
INSIDE = 0.35, 0.65  # of the way between two given


def draw_runs(
    rng: np.random.Generator, settings: RoughSettings, kind: Kind, p: RigParameters
) -> list[Run]:
    """Arguments of runs in the order of the campaign, as `record_campaign` takes them."""
    lasts = [between(rng, settings.durations) for _ in range(kind.runs)]
    whole = min(settings.most_samples / kind.rate, settings.most_time)
    part = min(whole / sum(lasts), 1.0)
    # one that would be too short stays as long as the shortest there is
    lasts = [round(max(x * part, settings.durations[0]), 1) for x in lasts]
    decays = kind.runs
    if kind.driven:
        decays = int(rng.integers(0, kind.runs // 2 + 1))
    driven = kind.runs - decays
    edges = np.linspace(LOWEST, HIGHEST, driven + 1)
    omegas = [low + (high - low) * rng.uniform(0.2, 0.8) for low, high in _pairs(edges)]
    runs: list[Run] = [{"omega": round(center(p) * x, 2)} for x in omegas]
    runs += [{"release": _release(rng, settings)} for _ in range(decays)]
    order = rng.permutation(kind.runs).tolist()
    out = [{**runs[i], "duration": lasts[i]} for i in order]
    return [_swung(rng, settings, kind, run) for run in out]


def sealed_runs(
    rng: np.random.Generator, settings: RoughSettings, kind: Kind, given: Sequence[Run]
) -> list[Run]:
    """Runs between and beyond the excitations that were given; decays where there are any."""
    omegas = sorted(run["omega"] for run in given if "omega" in run)
    releases = sorted(abs(run["release"]) for run in given if "release" in run)
    n = settings.sealed_runs
    decays = n if not omegas else int(bool(releases))
    longest = min(settings.sealed_longest, max(run["duration"] for run in given))
    runs: list[Run] = [{"omega": round(x, 2)} for x in _others(rng, omegas, n - decays)]
    runs += [
        {"release": round(x * float(rng.choice((-1.0, 1.0))), 3)}
        for x in _others(rng, releases, decays)
    ]
    out = [
        {**run, "duration": round(float(rng.uniform(settings.durations[0], longest)), 1)}
        for run in runs
    ]
    return [_swung(rng, settings, kind, run) for run in out]


def shows(p: RigParameters, runs: Sequence[Run], noise: float, *, sliding: float = SLIDING) -> bool:
    """True if the column moves in every run, never too far, and a rider slides in a share of them.

    Args:
        p: the rig, without effects. runs: of it. noise: of the readings [rad].
        sliding: share of the runs in which the rider must leave its place, once at least if any.
    """
    rig = VirtualRig(p)
    period = 2.0 * math.pi / center(p)
    slid = 0
    for run in runs:
        begin(rig, run)
        until = min(run["duration"], max(PERIODS * period, AT_LEAST))
        ts = np.arange(PACE * period, until, PACE * period)
        phi1, phi2 = np.array([rig.motion(t)[:2] for t in ts.tolist()]).T
        if not (np.ptp(phi1) > max(MOVES, LOUD * noise) and np.abs(phi1).max() < FARTHEST):
            return False
        slid += np.ptp(phi2) > max(SLIDES, LOUD * noise)
    return not p.has_rider or slid >= math.ceil(sliding * len(runs))


def center(p: RigParameters) -> float:
    """Frequency of both bodies together [rad/s]."""
    return math.sqrt(p.k / (p.B1 + p.B2))


def _others(rng: np.random.Generator, given: list[float], n: int) -> list[float]:
    """Draws n values: beyond one end, then in the widest gaps between those given."""
    if n == 0:
        return []
    more, up = 1.0 + float(rng.uniform(*BEYOND)), bool(rng.random() < 0.5)
    beyond = given[-1] * more if up else given[0] / more
    gaps = sorted(_pairs(given), key=lambda pair: pair[0] / pair[1])  # the widest first
    out = [beyond]
    for low, high in gaps[: n - 1]:
        out.append(low + (high - low) * float(rng.uniform(*INSIDE)))
    # of few given ones: the other end, and farther out in turn
    for i in range(n - len(out)):
        more = 1.0 + (1 + i // 2) * float(rng.uniform(*BEYOND))
        out.append(given[0] / more if up == (i % 2 == 0) else given[-1] * (more + BEYOND[1]))
    return out


def _swung(rng: np.random.Generator, settings: RoughSettings, kind: Kind, run: Run) -> Run:
    """An amplitude of its own, which only a measured drive can have."""
    if not kind.measured or "omega" not in run:
        return run
    return {**run, "swing": round(float(rng.uniform(*settings.swing)), 3)}


def _release(rng: np.random.Generator, settings: RoughSettings) -> float:
    size = float(rng.uniform(*settings.releases))
    return round(size * float(rng.choice((-1.0, 1.0))), 3)


def _pairs(x) -> list[tuple[float, float]]:
    return list(itertools.pairwise(x))
