"""Change of the readings that only a hidden effect explains, measured on the virtual rig.

In short windows the rig with the effect is compared with the same rig without it, restarted from
the same state at the window's start, so that phases do not run away. What a change of the rig's
own numbers, of the drive's phase, of the zero of phi1 or of the window's first state could explain
as well (by differences of the rig without the effect) is projected out.
"""

import dataclasses
import functools
from collections.abc import Mapping, Sequence

import numpy as np

from tp_jax.rig import RigParameters, VirtualRig
from trials.restart import plain_window

WINDOW = 0.5  # s
PER_RUN = 5  # windows of a run that are looked at, spread over it at random
CHANGE = 1e-3  # relative, of a parameter; also in rad, rad/s and rad
RANK = 1e-8  # relative size of a direction that counts as none

FREE = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")


@dataclasses.dataclass(frozen=True)
class Bench:
    """Properties of a campaign that decide how small an effect it shows.

    Attributes:
        parameters: of the rig. plan: arguments of `VirtualRig.start` for each run.
        duration: of a run [s]. rate: samples a second. noise: of a reading [rad].
        free: numbers of the rig that are not known beforehand.
        seed: of chance in effects, and of where the windows lie.
        window: length of a window [s]. per_run: how many are looked at in a run.
        weights: noise of phi1 and of phi2, over `noise`; None: both have it.
        cousins_by_kind: an effect that is akin to one of the catalogue is found by a test for that.
        part: of the campaign that `plan` is, the rest showing as much in proportion.

    A run of the plan may have a "duration" [s] of its own, and a "swing" as in `record_campaign`.
    """

    parameters: RigParameters
    plan: Sequence[Mapping[str, float]]
    duration: float = 10.0
    rate: float = 250.0
    noise: float = 1e-3
    free: tuple[str, ...] = FREE
    seed: int = 0
    window: float = WINDOW
    per_run: int = PER_RUN
    weights: tuple[float, float] | None = None
    cousins_by_kind: bool = False
    part: float = 1.0

    def lasts(self, run: Mapping[str, float]) -> float:
        """Duration of a run [s]."""
        return run.get("duration", self.duration)

    @property
    def samples(self) -> int:
        """Readings of all angles in the whole campaign."""
        times = [self.lasts(run) for run in self.plan]
        channels = 2 if self.parameters.has_rider else 1
        return round(channels * sum(times) * self.rate / self.part)

    @property
    def runs(self) -> int:
        """Number of runs of the whole campaign."""
        return round(len(self.plan) / self.part)


def noncentralities(
    bench: Bench, id: str, sizes: Sequence[float], shapes: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of squares over the samples of each run, of what only the effect explains.

    Args:
        bench: the campaign.
        id, sizes, shapes: of the effect, as `VirtualRig` takes them.

    Returns:
        (runs,) in variances of the noise; (runs,) sums of squares of each run's own amplitudes,
        where it has any.
    """
    rig = VirtualRig(bench.parameters, {id: sizes}, bench.seed, shapes)
    rng = np.random.default_rng([bench.seed, 7])
    changes, directions, squares, ends, shares = [], [], [], [], []
    for run in bench.plan:
        lasts = bench.lasts(run)
        n = max(round(min(bench.window, lasts) * bench.rate), 4)
        places = max(int(lasts * bench.rate) // n, 1)
        looked_at = min(bench.per_run, places)
        rig.amplitude = rig.parameters.A * run.get("swing", 1.0)
        rig.start(omega=run.get("omega"), release=run.get("release"), duration=lasts)
        squares.append(sum(x * x for x in rig.run_values.get(id, ())))
        for place in sorted(rng.choice(places, looked_at, replace=False).tolist()):
            times = (place * n + np.arange(n)) / bench.rate
            state, readings = _observed(rig, times)
            at = functools.partial(_window, run, times)
            plain = at(bench.parameters, state)
            own = np.stack(_state_directions(bench, at, state, plain), axis=1)
            rest = np.column_stack([readings - plain, *_directions(bench, at, state, plain, run)])
            if bench.weights is not None:
                weight = np.repeat(bench.weights, n)[:, None]
                own, rest = own / weight, rest / weight
            rest = rest - own @ np.linalg.lstsq(own, rest, rcond=RANK)[0]
            changes.append(rest[:, 0])
            directions.append(rest[:, 1:])
        ends.append(sum(map(len, changes)))
        shares.append(looked_at / places * bench.part)
    change, along = np.concatenate(changes), np.concatenate(directions)
    norms = np.linalg.norm(along, axis=0)
    along = along[:, norms > 0.0] / norms[norms > 0.0]
    left = change - along @ np.linalg.lstsq(along, change, rcond=RANK)[0]
    sums = np.array([(part**2).sum() for part in np.split(left, ends[:-1])])
    return sums / bench.noise**2 / np.array(shares), np.array(squares)


def _observed(
    rig: VirtualRig, times: np.ndarray
) -> tuple[tuple[float, float, float, float], np.ndarray]:
    """State of the bodies at the first of some times, and readings (n, 2) at all of them."""
    state, readings = None, []
    for t in times.tolist():
        true = rig.true_time(t)
        state = rig.motion(true) if state is None else state
        readings.append(rig.advance(true))
    assert state is not None
    return state, np.array(readings).T.ravel()


def _window(run, times, parameters, state, phase=0.0) -> np.ndarray:
    swing = run.get("swing", 1.0)
    if swing != 1.0:
        parameters = dataclasses.replace(parameters, A=parameters.A * swing)
    return plain_window(
        parameters, run.get("omega"), state, times[0], (times - times[0]).tolist(), phase
    ).T.ravel()


def _state_directions(bench: Bench, at, state, plain) -> list[np.ndarray]:
    """Changes of a window's angles with phi1, v1, v2 and phi2 of its first state."""
    out = []
    for i in (0, 2, 3):
        moved = list(state)
        moved[i] += CHANGE
        out.append((at(bench.parameters, tuple(moved)) - plain) / CHANGE)
    return [*out, _constant(plain.size, 1)]


def _directions(bench: Bench, at, state, plain, run) -> list[np.ndarray]:
    """Changes with the rig's numbers, the drive's phase and the zero of phi1."""
    p = bench.parameters
    out = []
    for name in bench.free:
        other = dataclasses.replace(p, **{name: getattr(p, name) * (1.0 + CHANGE)})
        out.append((at(other, state) - plain) / CHANGE)
    phase = (at(p, state, CHANGE) - plain) / CHANGE if "omega" in run else np.zeros_like(plain)
    return [*out, phase, _constant(plain.size, 0)]


def _constant(size: int, channel: int) -> np.ndarray:
    out = np.zeros(size)
    out[channel * size // 2 : (channel + 1) * size // 2] = 1.0
    return out
