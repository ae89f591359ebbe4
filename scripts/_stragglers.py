"""Program of scripts/stragglers: fleets on many workers, by chance, from measured piece times."""

import argparse
import dataclasses
import heapq
import sys
from collections import deque
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._ledger import entries
from tp_jax.cli.arguments import Parser, count
from tp_jax.errors import InputError
from tp_jax.executors.pieces import MOST_DEATHS

ROOT = Path(__file__).parent.parent
LEDGER = ROOT / "trials" / "nulls.jsonl"
PAGE = ROOT / "docs" / "scale.md"

KIND = "rough"
"""Kind of the ledger's rigs: recorded so differently that their times differ fifty-fold."""

SEED = 46

FLEETS = ((20, 8), (200, 16), (200, 64), (1000, 64), (1000, 256))
"""Rigs, and workers."""

LOSSES = (0.0, 0.1, 2.0)
"""Workers lost in an hour of each worker: none; now and then; by a cluster that takes machines back
all the time."""

RESTART_S = 30.0
"""Time to fill a lost worker's place: a process that imports and reads compiled programs."""

HEADS = (
    "rigs",
    "workers",
    "lost in an hour",
    "wall time over the least",
    "processor time over the work",
    "given up",
)


@dataclasses.dataclass(frozen=True)
class Run:
    """A fleet from end to end.

    Attributes:
        wall_s: until the last rig ends [s]. spent_s: of all workers, that which was lost included
            [s]. given_up: rigs of which too many workers died.
    """

    wall_s: float
    spent_s: float
    given_up: int


def simulate(times: Sequence[float], workers: int, losses: float, rng: np.random.Generator) -> Run:
    """Pieces in their order, each to the worker that is free first, as `run_pieces` gives them.

    A piece whose worker is lost comes first again, and begins anew: in truth a diagnosis goes on
    from its fits, so this is the worst.

    Args:
        times: of the pieces [s]. workers: how many. losses: of each worker in an hour.
        rng: chance.
    """
    waiting = deque(enumerate(times))
    deaths = dict.fromkeys(range(len(times)), 0)
    spent = wall = 0.0
    given_up = 0
    idle = list(range(workers))
    events: list[tuple[float, int, int, int]] = []  # time, worker, piece or -1, whether lost
    now = 0.0
    while waiting or events:
        while waiting and idle:
            piece, needed = waiting.popleft()
            until = rng.exponential(3600.0 / losses) if losses else np.inf
            lost = until < needed
            spent += min(until, needed)
            heapq.heappush(events, (now + min(until, needed), idle.pop(), piece, int(lost)))
        now, worker, piece, lost = heapq.heappop(events)
        if piece < 0 or not lost:
            idle.append(worker)
            wall = now if piece >= 0 else wall
            continue
        deaths[piece] += 1
        if deaths[piece] < MOST_DEATHS:
            waiting.appendleft((piece, times[piece]))
        else:
            given_up, wall = given_up + 1, now
        heapq.heappush(events, (now + RESTART_S, worker, -1, 0))
    return Run(wall, spent, given_up)


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    return carried_out("stragglers", _stragglers, _parser().parse_args(argv), resumes=False)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/stragglers",
        description="How long fleets take where rigs take unlike times and workers are lost: by "
        "chance, from measured times.",
    )
    parser.add_argument(
        "--ledger",
        metavar="FILE",
        default=str(LEDGER),
        help="of the times (default trials/nulls.jsonl)",
    )
    parser.add_argument(
        "--runs", metavar="N", type=count, default=100, help="of each fleet (default 100)"
    )
    parser.add_argument(
        "--page",
        metavar="F",
        nargs="?",
        const=str(PAGE),
        help="gets the table in its place (default docs/scale.md)",
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _stragglers(args: argparse.Namespace) -> int:
    times = [each["cpu_s"] for each in entries(Path(args.ledger)) if each.get("kind") == KIND]
    if not times:
        raise InputError(f"{args.ledger} has no rigs of the kind {KIND}; give another --ledger.")
    told = table(np.array(times), args.runs)
    print(told)
    if args.page is not None:
        markdown.put_into(Path(args.page), "stragglers", told)
    return 0


def table(times: np.ndarray, runs: int) -> str:
    """Medians and 90 % ranges, as Markdown.

    Args:
        times: (n,) that were measured [s]; drawn from with replacement.
        runs: of each fleet.
    """
    rng = np.random.default_rng(SEED)
    rows = []
    for rigs, workers in FLEETS:
        for losses in LOSSES:
            walls, spent, lost = [], [], 0
            for _ in range(runs):
                drawn = rng.choice(times, rigs)
                run = simulate(drawn.tolist(), workers, losses, rng)
                least = max(drawn.sum() / workers, drawn.max())
                walls.append(run.wall_s / least)
                spent.append(run.spent_s / drawn.sum())
                lost += run.given_up
            rows.append(
                (
                    rigs,
                    workers,
                    f"{losses:g}",
                    _range(walls),
                    _range(spent),
                    f"{lost} of {rigs * runs}",
                )
            )
    said = (
        f"{len(times)} measured times: median {np.median(times):.0f} s, {times.min():.0f} to "
        f"{times.max():.0f} s. {runs} runs of each fleet; median, and 5 % to 95 %."
    )
    return f"{markdown.table(HEADS, rows)}\n\n({said} {markdown.circumstances(SEED)})"


def _range(values: Sequence[float]) -> str:
    middle, low, high = np.quantile(values, (0.5, 0.05, 0.95))
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


if __name__ == "__main__":
    sys.exit(main())
