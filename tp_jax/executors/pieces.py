"""The seam: pieces of work go to an executor, their results come as they end.

A piece is a key and what its work is called with. Work must be idempotent: a piece whose worker
died is submitted again, and one that two workers do has one result, since files are replaced whole.
"""

import math
import re
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tp_jax.errors import InputError
from tp_jax.executors.calls import Call, Fault, Outcome, carry_out, kept_result, pickled
from tp_jax.executors.choice import ExecutorChoice
from tp_jax.executors.workers import Refused

MOST_DEATHS = 5
"""Workers that die of one piece before it is given up: a machine that is switched off, or a hand
that kills, seldom strikes the same piece so often; a piece that takes all memory always does."""

FOLDER = "pieces"
"""Folder of the results, in the folder of a study."""

_KEY = re.compile(r"[\w+=-][\w.+=-]{0,199}")


@dataclass(frozen=True)
class Piece:
    """A piece of work.

    Attributes:
        key: names its result: letters, digits, `_`, `.`, `+`, `=`, `-`.
        arguments: of the work; they travel to another process.
        of: says what goes in, a digest for instance; a result that is kept counts only if it was
            made of the same.
    """

    key: str
    arguments: tuple = ()
    of: str = ""

    def __post_init__(self) -> None:
        if not _KEY.fullmatch(self.key):
            raise ValueError(f"{self.key!r} cannot name a file; use letters, digits, _.+=-.")


@dataclass(frozen=True)
class Ended:
    """A piece that has ended.

    Attributes:
        piece: which. result: of its work; as JSON has it where results are kept.
        fault: why there is none. kept: whether the result was there before.
    """

    piece: Piece
    result: Any = None
    fault: Fault | None = None
    kept: bool = False


def run_pieces(
    work: Callable[..., Any],
    pieces: Sequence[Piece],
    choice: ExecutorChoice,
    *,
    folder: Path | None = None,
    until: float = math.inf,
    uses_jax: bool = True,
    pieces_per_worker: int | None = None,
) -> Iterator[Ended]:
    """Does pieces, and gives each once, in the order in which they end.

    Args:
        work: of a piece's arguments; a function that other processes can import.
        pieces: begun in this order; no two have the same key.
        choice: where they are done, and how many at once.
        folder: results are kept in `pieces/KEY.json` below it, and what is there is not done again;
            None: the work keeps its results itself, or the caller does.
        until: on `time.monotonic`; no piece is begun after it.
        uses_jax: whether workers prepare JAX.
        pieces_per_worker: of a process, after which another takes its place, since what JAX has
            compiled adds up. Dask's workers and Slurm's jobs do not follow it.

    Raises:
        ValueError: two pieces have one key.
        InputError: the executor cannot be used here.
    """
    if len({piece.key for piece in pieces}) < len(pieces):
        twice = next(k for k, n in Counter(piece.key for piece in pieces).items() if n > 1)
        raise ValueError(f"Two pieces have the key {twice!r}.")
    waiting: deque[Piece] = deque()
    for piece in pieces:
        before = None if folder is None else _read(folder, piece)
        if before is None:
            waiting.append(piece)
        else:
            yield Ended(piece, before.result, kept=True)
    if not waiting or time.monotonic() > until:
        return
    choice = replace(choice, workers=min(choice.workers, len(waiting)))
    deaths: Counter[str] = Counter()
    with choice.opened(folder, pieces_per_worker) as executor:
        running: dict[Future[Outcome], Piece] = {}
        while waiting or running:
            # no more in hand than run, or those in hand would begin after `until`
            while waiting and len(running) < choice.workers and time.monotonic() <= until:
                piece = waiting.popleft()
                call = _call(work, piece, folder, uses_jax)
                try:
                    running[executor.submit(carry_out, call)] = piece
                except Refused as fault:
                    # a cluster lets a user have so many jobs at once: those in hand go on
                    if not running:
                        raise InputError(
                            f"The executor {choice.kind} takes no work: {fault}"
                        ) from fault
                    waiting.appendleft(piece)
                    break
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                piece = running.pop(future)
                outcome = _outcome(future, folder, piece)
                if isinstance(outcome, Outcome):
                    yield Ended(piece, outcome.result, outcome.fault)
                    continue
                deaths[piece.key] += 1
                if deaths[piece.key] < MOST_DEATHS:
                    waiting.appendleft(piece)
                else:
                    yield Ended(piece, fault=_given_up(outcome))


def done_before(folder: Path, pieces: Sequence[Piece]) -> list[Piece]:
    """Returns the pieces whose results are kept in the folder."""
    return [piece for piece in pieces if _read(folder, piece) is not None]


def forget_pieces(folder: Path, pieces: Sequence[Piece]) -> None:
    """Takes away what is kept of these pieces, so that they are done anew."""
    for piece in pieces:
        _file(folder, piece).unlink(missing_ok=True)


def _call(work: Callable[..., Any], piece: Piece, folder: Path | None, uses_jax: bool) -> Call:
    # a worker may be in another folder
    paths = tuple(str(Path(each).absolute()) for each in sys.path)
    file = None if folder is None else _file(folder, piece).absolute()
    call = pickled(work, piece.arguments)
    return Call(call, paths, uses_jax, file, piece.key, piece.of)


def _outcome(
    future: "Future[Outcome]", folder: Path | None, piece: Piece
) -> Outcome | BaseException:
    """Returns what came back of a piece, or the exception by which its worker was lost."""
    lost = CancelledPiece() if future.cancelled() else future.exception()
    if lost is None:
        return future.result()
    # it may have died after the result was written
    before = None if folder is None else _read(folder, piece)
    return lost if before is None else before


class CancelledPiece(RuntimeError):
    """The executor took a piece back."""


def _given_up(lost: BaseException) -> Fault:
    said = f"{type(lost).__name__}: {' '.join(str(lost).split())}".rstrip(": ")
    return Fault("WorkerLost", f"{MOST_DEATHS} workers died of it, the last by {said}")


def _file(folder: Path, piece: Piece) -> Path:
    return folder / FOLDER / f"{piece.key}.json"


def _read(folder: Path, piece: Piece) -> Outcome | None:
    return kept_result(_file(folder, piece), piece.key, piece.of)
