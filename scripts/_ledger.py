"""A study that grows call by call: each rig is a line of JSON in a file of the repository.

A call adds the rigs that are not there yet; one that is cut off has lost the rigs in hand. Lines
are of a version of the program, so that those of another are not pooled with them.
"""

import argparse
import dataclasses
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from scripts._version import DIGITS, computed
from tp_jax.cli.arguments import add_executor, executor_of, positive
from tp_jax.executors import Piece, run_pieces


def add_ledger(parser: argparse.ArgumentParser, ledger: Path, version: str = "") -> None:
    """Arguments that a study with a ledger takes: --ledger, --version, --limit-s, and those of
    `add_executor`.

    Args:
        parser: gets them. ledger: by default. version: of the lines that count, by default; empty:
            the digest of what a diagnosis computes, since the package's version stays the same
            over many changes of it.
    """
    parser.add_argument(
        "--ledger",
        metavar="FILE",
        default=str(ledger),
        help=f"where lines are added (default trials/{ledger.name})",
    )
    parser.add_argument(
        "--version",
        metavar="V",
        default=version or computed()[:DIGITS],
        help="of the lines that count (default that of the program as it is, %(default)s)",
    )
    add_executor(parser)
    parser.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no rig after so many seconds",
    )


def entries(ledger: Path) -> list[dict[str, Any]]:
    """All whole lines of a ledger; a rig whose line was cut off is looked at again."""
    found = []
    text = ledger.read_text(encoding="utf-8", errors="replace") if ledger.is_file() else ""
    for line in text.split("\n"):
        try:
            found.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return found


def extended(
    study: str, args: argparse.Namespace, look: Callable[..., Any], tasks: Sequence[tuple]
) -> tuple[list[Any], int]:
    """Looks at rigs and adds a line for each.

    Args:
        study: its name, for what is said of faults.
        args: of `add_ledger`.
        look: makes of a task's members a dataclass, in another process.
        tasks: rigs that are not in the ledger.

    Returns:
        What was found, and the exit code: 1 if any rig failed.
    """
    ledger, until = Path(args.ledger), time.monotonic() + args.limit_s
    ledger.parent.mkdir(parents=True, exist_ok=True)
    found, status = [], 0
    with ledger.open("a", encoding="utf-8") as file:
        if file.tell() and not ledger.read_bytes().endswith(b"\n"):
            file.write("\n")  # of a line that was cut off
        pieces = [Piece("-".join(map(str, task[:-1])), task) for task in tasks]
        for ended in run_pieces(look, pieces, executor_of(args), until=until):
            if ended.fault is None:
                found.append(ended.result)
                file.write(json.dumps(dataclasses.asdict(found[-1])) + "\n")
                file.flush()
            else:
                rig = " ".join(map(str, ended.piece.arguments[:-1]))  # the last is the version
                print(f"{study}: rig {rig} failed: {ended.fault}", file=sys.stderr)
                status = 1
    return found, status
