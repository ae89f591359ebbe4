"""Bench that the measures share: scale, peers, each peer's tolerance for the error asked for."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import reference
from .peer import Peer
from .problem import Scale, bench, times
from .timing import capped, interleaved

TARGET = 1e-5
"""Largest error of an angle [rad] at which costs are compared: a hundredth of a sensor's noise."""

LOOSEST = 0.1
"""Beginning of our ladder of tolerances [rad]."""


@dataclass
class Bench:
    """One run of the benchmark.

    Attributes:
        scale: how much is computed.
        peers: ours first.
        tell: takes one line on what is going on.
        draws_duration: seconds of a run in the robustness.
        against: commit whose diagnosis is run beside this checkout's; None: this one's alone.
        chosen: kept by `tolerance`.
    """

    scale: Scale
    peers: list[Peer]
    tell: Callable[[str], None]
    draws_duration: float = 10.0
    against: str | None = None
    chosen: dict[tuple[str, float], tuple[float, float]] = field(default_factory=dict)

    @property
    def ours(self) -> Peer:
        """The engine."""
        return self.peers[0]

    def schedule(self, peer: Peer) -> tuple[float, ...]:
        """Tolerances to choose from, loosest first.

        Ours begins higher: its tolerance is an angle in radians, and reversals bound its steps
        whatever it is, so that even a tenth may be enough.
        """
        if peer is not self.ours:
            return self.scale.tolerances
        first = self.scale.tolerances[0]
        above = round(2 * math.log10(LOOSEST / first))
        return (*(first * 10.0 ** (n / 2) for n in range(above, 0, -1)), *self.scale.tolerances)

    def truth(self, row: np.ndarray, eps: float, ts: np.ndarray) -> np.ndarray:
        """Reference (n, 2) of one run."""
        return reference.angles(row[None], eps, ts, self.scale.reference)[0]

    def tolerance(self, peer: Peer, eps: float) -> tuple[float, float]:
        """Loosest tolerance at which one run of the preset has the error asked for, and its error.

        If none has: the one with the smallest error.
        """
        key = peer.name, eps
        if key not in self.chosen:
            truth = self.truth(bench(), eps, self.scale.ts)
            run = lambda tol: largest(peer.run(bench(), eps, self.scale.ts, tol), truth)  # noqa: E731
            self.chosen[key] = loosest(run, self.schedule(peer), self.scale.cap)
        return self.chosen[key]

    def timed(self, peer: Peer, row: np.ndarray, eps: float, tol: float) -> tuple[float, Any]:
        """Seconds and angles (n, 2) of one run, infinity and None above the cap."""
        # as many samples whatever the duration, so that nothing is compiled anew
        n = self.scale.ts.size
        call = lambda duration: peer.run(row, eps, np.linspace(0.0, duration, n), tol)  # noqa: E731
        took, angles = capped(call, self.scale.duration, self.scale.cap)
        if took < 0.5:  # short enough to be read more than once
            took = min(interleaved({"": lambda: call(self.scale.duration)}, 3)[""])
        return took, angles


def largest(values: np.ndarray, truth: np.ndarray) -> float:
    """Largest error; infinite where something failed."""
    error = float(np.max(np.abs(values - truth)))
    return error if math.isfinite(error) else math.inf


def loosest(
    error_at: Callable[[float], float], tolerances: tuple[float, ...], cap: float
) -> tuple[float, float]:
    """Loosest tolerance with an error up to `TARGET`, and that error; else the best there is.

    Ends early where one evaluation takes longer than the cap; the first may also compile.
    """
    best = (tolerances[0], math.inf)
    for i, tol in enumerate(tolerances):
        start = time.perf_counter()
        error = error_at(tol)
        if error < best[1]:
            best = tol, error
        if error <= TARGET or (i and time.perf_counter() - start > cap):
            break
    return best


def reach(scale: Scale, duration: float) -> np.ndarray:
    """Sample times of another duration than the scale's, at most as long."""
    return times(min(duration, scale.duration))
