"""Program of scripts/executors: one study by all executors, with and without killed workers."""

import argparse
import dataclasses
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from tp_jax.cli.arguments import Parser, count, positive
from tp_jax.executors import ExecutorChoice, Piece, run_pieces

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "scale.md"

KINDS = ("local", "ray", "dask")
"""Slurm's jobs are tried by a test, with submitit's own executor in the place of a cluster."""

RUNS = 40
"""Runs of a piece: a second or two of one processor."""

SEED = 40

HEADS = (
    "executor",
    "workers killed",
    "pieces",
    "results as alone",
    "begun",
    "wall s",
    "efficiency",
)


@dataclasses.dataclass(frozen=True)
class Line:
    """A study from end to end.

    Attributes:
        executor: how. killed: workers; pieces: that ended. same: of them, with the result of
            a process alone. begun: times that any piece was begun. wall_s: of all [s].
        efficiency: wall time of two processes without an executor, over this one's.
    """

    executor: str
    killed: int
    pieces: int
    same: int
    begun: int
    wall_s: float
    efficiency: float | None


def study(number: int, begun: str, runs: int) -> str:
    """Runs of drawn rigs; a digest of every bit of their angles. Says in a file that it began."""
    import tp_jax as tp

    with Path(begun, f"{number}.txt").open("a") as file:
        file.write(f"{os.getpid()}\n")
    rng = np.random.default_rng([SEED, number])
    preset = tp.presets.values("bench")
    t = np.arange(2501) / 250.0
    digest = hashlib.sha256()
    for _ in range(runs):
        drawn = {name: preset[name] * rng.uniform(0.8, 1.2) for name in ("k", "Ts1", "M1", "omega")}
        run = tp.simulate(tp.presets.double_pendulum(**preset | drawn), t)
        digest.update(np.ascontiguousarray([run.phi1, run.phi2]).tobytes())
    return digest.hexdigest()


def begun_times(begun: Path) -> dict[int, int]:
    """Counts how often each piece was begun, by its number."""
    return {int(f.stem): len(f.read_text().split()) for f in begun.glob("*.txt")}


class Hand:
    """Kills the process that began a piece last, every so many seconds, so many times.

    Pieces write their process into NUMBER.txt in the folder `begun` (see `study`).
    """

    def __init__(self, begun: Path, times: float, every_s: float) -> None:
        self.begun, self.times, self.every_s = begun, times, every_s
        self.killed: list[int] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._strike, daemon=True)

    def __enter__(self) -> "Hand":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    def _strike(self) -> None:
        while not self._ended.is_set() and len(self.killed) < self.times:
            files = sorted(self.begun.glob("*.txt"), key=lambda f: f.stat().st_mtime_ns)
            pids = [int(pid) for f in files for pid in f.read_text().split()]
            new = [pid for pid in pids if pid not in self.killed]
            wait_s = 0.05
            if new:
                try:
                    os.kill(new[-1], signal.SIGKILL)
                except ProcessLookupError:
                    pass
                else:
                    self.killed.append(new[-1])
                wait_s = self.every_s
            self._ended.wait(wait_s)


def main(argv: Sequence[str] | None = None) -> int:
    parser = Parser(
        prog="scripts/executors",
        description="The same pieces through every executor, with and without killed workers.",
    )
    parser.add_argument("--pieces", metavar="N", type=count, default=200, help="default 200")
    parser.add_argument(
        "--runs",
        metavar="N",
        type=count,
        default=RUNS,
        help=f"of a piece (default {RUNS}: a second or two)",
    )
    parser.add_argument("--workers", metavar="N", type=count, default=2, help="default 2")
    parser.add_argument(
        "--every-s",
        metavar="S",
        type=positive,
        default=30.0,
        help="between two killed workers (default 30)",
    )
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--write", action="store_true", help="put the table into docs/scale.md")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return carried_out("executors", _study, parser.parse_args(argv), resumes=False)


def _study(args: argparse.Namespace) -> int:
    with tempfile.TemporaryDirectory() as place:
        lines = list(compared(args, Path(place)))
    told = f"{table(lines)}\n\n({args.workers} workers. {markdown.circumstances(SEED)})"
    print(told)
    if args.write:
        markdown.put_into(PAGE, "executors", told)
    return 0 if all(line.same == args.pieces for line in lines) else 1


def compared(args: argparse.Namespace, place: Path) -> Iterator[Line]:
    """The pieces without an executor, then through each, then with workers killed."""
    alone, alone_s = _alone(args, place / "alone")
    yield Line(
        f"none: {args.workers} processes of as many pieces",
        0,
        len(alone),
        len(alone),
        len(alone),
        alone_s,
        1.0,
    )
    for kills in (False, True):
        for kind in args.kinds:
            folder = place / f"{kind}-{kills}"
            begun = folder / "begun"
            begun.mkdir(parents=True)
            pieces = [Piece(f"piece-{n}", (n, str(begun), args.runs)) for n in range(args.pieces)]
            start = time.monotonic()
            with Hand(begun, np.inf if kills else 0, args.every_s) as hand:
                ended = list(
                    run_pieces(study, pieces, ExecutorChoice(kind, args.workers), folder=folder)
                )
            wall_s = time.monotonic() - start
            found = {each.piece.arguments[0]: each.result for each in ended}
            yield Line(
                kind,
                len(hand.killed),
                len(ended),
                sum(found.get(n) == result for n, result in alone.items()),
                sum(begun_times(begun).values()),
                wall_s,
                None if kills else alone_s / wall_s,
            )


def _alone(args: argparse.Namespace, folder: Path) -> tuple[dict[int, str], float]:
    """Results by number, and wall time, of plain processes that share the pieces."""
    folder.mkdir(parents=True)
    start = time.monotonic()
    code = "import sys; from scripts._executors import share; share(*sys.argv[1:])"
    running = [
        subprocess.Popen(
            [
                sys.executable,
                "-c",
                code,
                str(folder),
                str(k),
                *map(str, (args.workers, args.pieces, args.runs)),
            ],
            text=True,
            stdout=subprocess.PIPE,
        )
        for k in range(args.workers)
    ]
    found: dict[int, str] = {}
    for each in running:
        for line in each.communicate()[0].splitlines():
            number, result = line.split()
            found[int(number)] = result
    return found, time.monotonic() - start


def share(folder: str, k: str, workers: str, pieces: str, runs: str) -> None:
    """Does every so many-th piece in a process without an executor, as a worker does it."""
    from tp_jax.executors.calls import Call, carry_out, pickled

    for number in range(int(k), int(pieces), int(workers)):
        done = carry_out(Call(pickled(study, (number, folder, int(runs))), (), uses_jax=True))
        print(number, done.result, flush=True)


def table(lines: Sequence[Line]) -> str:
    """A line for each study, a Markdown table."""
    return markdown.table(
        HEADS,
        [
            (
                line.executor,
                line.killed or "–",
                line.pieces,
                line.same,
                line.begun,
                f"{line.wall_s:.0f}",
                "–" if line.efficiency is None else f"{line.efficiency:.2f}",
            )
            for line in lines
        ],
    )


if __name__ == "__main__":
    sys.exit(main())
