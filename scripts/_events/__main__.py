"""scripts/events: integration from event to event beside the engine, at equal error."""

import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

import numpy as np

import tp_jax as tp
from scripts._bench import problem
from scripts._bench.bench import TARGET
from scripts._bench.peers import ours
from scripts._carried_out import carried_out
from scripts._markdown import circumstances, table
from tp_jax.cli.arguments import Parser

from . import lanes

RELATIVE = 1e-3
"""Error of a derivative, by its largest value, at which costs are compared."""

SMALL = 1e-2
"""A derivative by a relative change that is smaller than so many of the largest counts as that."""

LADDER = tuple(10.0 ** (-n / 2) for n in range(6, 22))
"""Tolerances to choose from [rad]."""

HARD = 1e7
"""Slope of a smoothed sign [s] that is all but hard."""


class Case(NamedTuple):
    """What is computed: runs of the rows of `table` from `y0` (rest if None)."""

    name: str
    table: np.ndarray
    ts: np.ndarray
    y0: np.ndarray | None = None
    per_step: int = lanes.PER_STEP
    derivatives: bool = False

    def events(self, tolerance: float) -> np.ndarray:
        """Angles (N, n, 2), or derivatives (N, n, 2, 14), with hard friction."""
        found = self.found(tolerance)
        return found.angles if found.derivatives is None else found.derivatives

    def found(self, tolerance: float) -> lanes.Found:
        return lanes.run(
            self.table,
            self.ts,
            tolerance,
            self.y0,
            derivatives=self.derivatives,
            per_step=self.per_step,
        )

    def engine(self, eps: float, tolerance: float) -> np.ndarray:
        """The same by the engine, with smoothed friction."""
        if len(self.table) == 1:
            call = ours.sensitivities if self.derivatives else ours.run
            return call(self.table[0], eps, self.ts, tolerance)[None]
        if self.derivatives:
            models = ours._models(self.table, eps)
            found = tp.sensitivities(models, self.ts, self.y0, tolerance=tolerance)
            return np.roll(np.stack([found.phi1, found.phi2], axis=2), -4, axis=3)
        found = self.swept(eps, tolerance)
        return np.stack([found.phi1, found.phi2], axis=-1)

    def swept(self, eps: float, tolerance: float) -> tp.Sweep:
        return tp.sweep(
            ours._models(self.table, eps),
            self.ts,
            self.y0,
            tolerance=tolerance,
            velocities=False,
            threads=1,
        )

    def error(self, values: np.ndarray, truth: np.ndarray) -> float:
        """Median over the runs of the largest error [rad], or of derivatives by their size."""
        off = np.abs(values - truth).max(axis=(1, 2))
        if self.derivatives:
            unit = np.ones((len(self.table), lanes.D))
            unit[:, :10] = self.table[:, :10]
            size = np.abs(truth).max(axis=(1, 2)) * unit
            off = off * unit / np.maximum(size, SMALL * size.max(axis=1, keepdims=True))
            # a body at rest that is pushed a little stays where it is
            off = off[:, : lanes.D - 2 * (self.y0 is None)].max(axis=1)
        return float(np.median(off))


def cases(duration: float, many: int) -> list[Case]:
    """All of them, without derivatives."""
    ts = problem.times(duration)
    some = problem.sweep(many)
    one = {
        "bench": problem.bench(),
        "rider mostly stuck": problem.bench(Ts1=3.0),
        "fast and loose": problem.bench(omega=3.0, k=3.0, M1=0.3, Ts1=0.3),
        "paper-5.1": np.array(problem.PAPER),
    }
    found = [Case(f"{name}, one run", row[None], ts) for name, row in one.items()]
    found += [Case(f"bench ± 20 %, one of {many}", some, ts)]
    # as in estimation: windows of 0.1 s from states along a run, measured with some error
    model = ours._one(problem.bench(), problem.EPS[-1])
    motion = tp.simulate(model, problem.times(duration))
    states = np.stack([motion.phi1, motion.phi2, motion.omega1, motion.omega2], axis=1)
    rng = np.random.default_rng(0)
    starts = states[rng.integers(len(ts) // 2, len(ts), many)]
    starts = starts + rng.normal(size=starts.shape) * (1e-3, 1e-3, 0.02, 0.02)
    rows = np.repeat(problem.bench()[None], many, axis=0)
    found += [Case(f"windows of 0.1 s, one of {many}", rows, problem.times(0.1), starts)]
    found += [Case(f"a step for each sample, one of {many}", some, ts, per_step=1)]
    return found


def loosest(error_at: Callable[[float], float], target: float) -> float:
    """Loosest tolerance of the ladder within the target."""
    return next((tol for tol in LADDER if error_at(tol) <= target), LADDER[-1])


def paired(calls: Mapping[Any, Callable], rounds: int) -> dict[Any, np.ndarray]:
    """CPU seconds of each call in each round, one after the other: A B C, A B C, ...

    CPU time, since a machine may be busy with other things.
    """
    repeats = {}
    for key, call in calls.items():
        call()
        repeats[key] = int(np.clip(0.02 / max(_seconds(call, 1), 1e-6), 1, 100))
    read = [
        {key: _seconds(call, repeats[key]) for key, call in calls.items()} for _ in range(rounds)
    ]
    return {key: np.array([one[key] for one in read]) for key in calls}


def _seconds(call: Callable, repeats: int) -> float:
    start = time.process_time()
    for _ in range(repeats):
        call()
    return (time.process_time() - start) / repeats


def compared(case: Case, rounds: int) -> tuple[list[str], list[float]]:
    """A row of the costs, and by how much hard and smoothed friction differ, slope by slope."""
    target = RELATIVE if case.derivatives else TARGET
    hard = case.events(LADDER[-1])
    tolerance = loosest(lambda tol: case.error(case.events(tol), hard), target)
    found = case.found(tolerance)
    calls: dict[Any, Callable] = {0.0: lambda: case.events(tolerance)}
    steps, differ = {}, []
    for eps in problem.EPS:
        smooth = case.engine(eps, LADDER[-1])
        its = loosest(lambda tol, e=eps, s=smooth: case.error(case.engine(e, tol), s), target)
        calls[eps] = lambda e=eps, tol=its: case.engine(e, tol)
        steps[eps] = np.median(case.swept(eps, its).steps)
        differ.append(case.error(hard, smooth))
    if not case.derivatives:
        differ.append(case.error(hard, case.engine(HARD, LADDER[-1])))
    read = paired(calls, rounds)
    each = 1e6 / len(case.table)
    name = f"– its {lanes.D} derivatives" if case.derivatives else case.name
    of_events = (np.median(found.steps), np.median(found.events), np.median(read[0.0]) * each)
    cells = [name, *(f"{x:,.0f}" for x in of_events)]
    for eps in problem.EPS:
        took, ratio = np.median(read[eps]) * each, np.median(read[eps] / read[0.0])
        # the engine's steps with tangents are others, which it does not tell
        cells += [
            "" if case.derivatives else f"{steps[eps]:,.0f}",
            f"{took:,.0f}",
            f"{ratio:.1f} ×",
        ]
    return cells, differ


def drawn(draws: int, duration: float) -> str:
    """What becomes of runs anywhere in the package's bounds."""
    case = Case("", problem.anywhere(draws), problem.times(duration))
    found, swept = case.found(1e-6), case.swept(problem.EPS[-1], 1e-5)
    calls = {
        "events": lambda: case.found(1e-6),
        "engine": lambda: case.swept(problem.EPS[-1], 1e-5),
    }
    cost = {name: float(read[0]) for name, read in paired(calls, 1).items()}
    lost = ~found.complete
    _, _, B1, B2, c1, _, Tv, _, Tst, T0, _ = case.table.T
    rate = c1 / B1 + (Tv + Tst * T0) * (1.0 / B1 + 1.0 / B2)  # of smooth friction, at rest
    sharp = case.found(1e-9)
    both = found.complete & sharp.complete
    off = np.abs(found.angles[both] - sharp.angles[both]).max(axis=(1, 2))
    return (
        f"Of {draws} draws from all bounds {lost.sum()} were given up after {lanes.MOST:,} steps "
        f"(the engine: {np.sum(~np.asarray(swept.complete))}), where friction rises with speed "
        f"at a rate of {np.min(rate[lost], initial=np.inf):.2g} 1/s or more; {np.sum(off > 1e-3)} "
        f"others are wrong by more than a mrad. All together take {cost['events']:.2g} s, by the "
        f"engine {cost['engine']:.2g} s. Median of steps {np.median(found.steps):.0f}, of the "
        f"engine's {np.median(swept.steps):.0f}."
    )


def _table(args: Any) -> int:
    duration, many, rounds = (0.2, 2, 1) if args.quick else (args.duration, args.runs, args.rounds)
    heads = ["", "steps", "events", "µs"]
    for eps in problem.EPS:
        heads += [f"engine, ε = {eps:,.0f} s: steps", "µs", "takes"]
    rows, differ = [], []
    for case in cases(duration, many):
        cells, angles = compared(case, rounds)
        more, by = compared(case._replace(derivatives=True), rounds)
        rows += [cells, more]
        told = [f"{1e3 * x:.2g} mrad" for x in angles]
        differ.append([case.name, *told, *(f"{100.0 * x:.2g} %" for x in by)])
    print(table(heads, rows), "\n")
    slopes = [f"ε = {eps:,.0f} s" for eps in (*problem.EPS, HARD)]
    slopes += [f"derivatives, {slope}" for slope in slopes[:2]]
    print(table(["hard against", *slopes], differ), "\n")
    print(drawn(2 if args.quick else args.draws, duration), "\n")
    print(
        f"{duration:g} s at {problem.RATE:g} Hz; errors {TARGET:g} rad, of derivatives "
        f"{RELATIVE:g} of their largest; CPU time; medians of {rounds} rounds. {circumstances(0)}"
    )
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    parser = Parser(
        prog="scripts/events",
        description="Integrates hard friction from event to event, beside the engine.",
    )
    parser.add_argument("--quick", action="store_true", help="few and short runs, to see it work")
    parser.add_argument("--duration", type=float, default=10.0, help="of a run [s] (default 10)")
    parser.add_argument("--runs", type=int, default=64, help="side by side (default 64)")
    parser.add_argument("--rounds", type=int, default=9, help="of readings (default 9)")
    parser.add_argument("--draws", type=int, default=1024, help="from all bounds (default 1024)")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return carried_out("events", _table, parser.parse_args(argv), resumes=False)


if __name__ == "__main__":
    sys.exit(main())
