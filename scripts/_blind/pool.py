"""scripts/blind pool: a trial that grows a few rigs a call, kept as a ledger in the repository."""

import argparse
import contextlib
import dataclasses
import re
import shutil
import subprocess
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from scripts import _markdown as markdown
from scripts._ledger import entries, extended
from scripts._version import DIGITS, computed, unchanged
from tp_jax.cli.arguments import add_executor, positive
from tp_jax.errors import InputError

ROOT = Path(__file__).parent.parent.parent
POOLS = ROOT / "trials" / "pools"
FOLDER = ROOT / ".cache" / "pools"
"""Folder of the rigs in hand; each goes when its line is written."""

MOST_MINUTES = 20.0
"""Minutes of a call at most, so that it fits between other work."""

FIRST_GUESS = 180.0
"""Seconds that a rig is taken to need while the ledger holds none; most need less."""

NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")

HEADS = (
    "version",
    "commit",
    "rigs",
    "cause first",
    "from 3 ×",
    "false alarms",
    "unknown, outside",
    "harm",
    "CPU s a rig",
)

KNOWN = ("case", "kind", "effects", "verdict", "causes", "multiple", "shrink")
"""Fields of a judged rig that stand in its line already."""


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig.

    Attributes:
        number: in the pool. seed: of all chance in it.
        rigs, kind: as in a trial: clean or rough; one, two, none, outside or cousin.
        version: digest of what the package computes that diagnosed it (see `_version`).
        commit: in which that package stands, if any.
        hidden: id -> sizes, and the multiple of the detectable size by the rig's own scale.
        detectable: times that the hidden size is the one that the diagnosis calls detectable.
        verdict, causes: of the diagnosis.
        shrink: as the diagnosis has it, on the recording it held out.
        probability: that it states of its first cause.
        sealed: on runs that were never given, shrink, the best that could be, and harm.
        judged: the other answers of `trials.judge`.
        cpu_s: of the diagnosis and the sealed runs [s].
    """

    number: int
    seed: int
    rigs: str
    kind: str
    version: str
    commit: str | None
    hidden: dict[str, dict[str, Any]]
    detectable: float | None
    verdict: str
    causes: list[str]
    shrink: float | None
    probability: float | None
    sealed: dict[str, Any]
    judged: dict[str, Any]
    cpu_s: float


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds `pool`."""
    parser = commands.add_parser(
        "pool",
        help="add rigs to a trial that grows, or score it",
        description="Draws rigs, diagnoses them and adds a line for each to "
        "trials/pools/NAME.jsonl; the same call adds more. No rig is drawn twice.",
    )
    parser.add_argument("name", metavar="NAME", type=_name, help="of the pool: a-z, 0-9 and -")
    parser.add_argument(
        "--score", action="store_true", help="add nothing; show all tables of one version too"
    )
    parser.add_argument(
        "--rigs", choices=("clean", "rough"), help="of a new pool (default clean; see `make`)"
    )
    parser.add_argument(
        "--minutes",
        metavar="M",
        type=positive,
        default=MOST_MINUTES,
        help="of this call at most; a rig is begun only if it should end before "
        f"(default and most {MOST_MINUTES:g})",
    )
    add_executor(parser)
    parser.add_argument(
        "--version",
        metavar="V,…",
        help="whose tables are shown, together (default the last one tried)",
    )
    parser.add_argument("--markdown", metavar="F", help="gets the tables, replacing it")
    parser.add_argument(
        "--debug",
        action="store_true",
        default=argparse.SUPPRESS,
        help="show the traceback of a fault",
    )
    parser.set_defaults(run=run_pool)


def _name(text: str) -> str:
    if not NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(f"NAME must be of a-z, 0-9 and -, but is {text!r}")
    return text


def run_pool(args: argparse.Namespace) -> int:
    """Exit code."""
    ledger = POOLS / f"{args.name}.jsonl"
    if args.minutes > MOST_MINUTES:
        raise InputError(
            f"--minutes must be at most {MOST_MINUTES:g}, not {args.minutes:g}; the same call adds "
            "more."
        )
    status = 0
    if not args.score:
        with _held(args.name):
            status = _grown(args, ledger, look)
    rows = read(ledger)
    if not rows:
        raise InputError(
            f"The pool {args.name} is empty; `./scripts/blind pool {args.name}` adds to it."
        )
    shown(args, rows)
    return status


def read(ledger: Path) -> list[Row]:
    """The rigs of a ledger, each once, as it was written first."""
    first: dict[int, Row] = {}
    for entry in entries(ledger):
        row = Row(**entry)
        first.setdefault(row.seed, row)
    return list(first.values())


@contextlib.contextmanager
def _held(name: str) -> Iterator[None]:
    """One call at a time draws rigs of a pool, or two would draw the same.

    Raises:
        InputError: another call is at it.
    """
    try:
        import fcntl
    except ImportError:  # where there are no locks, nothing is held
        yield
        return
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / f"{name}.lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # goes with the process
        except OSError as fault:
            raise InputError(f"Another call adds to the pool {name}; wait for its end.") from fault
        yield


def _grown(args: argparse.Namespace, ledger: Path, look: Callable[..., Row]) -> int:
    """Adds rigs for so many minutes; the exit code."""
    rows = read(ledger)
    rigs = rows[0].rigs if rows else args.rigs or "clean"
    if args.rigs not in (None, rigs):
        raise InputError(
            f"The pool {args.name} is of {rigs} rigs; give {args.rigs} ones another name."
        )
    # The last rig of a call should end within it. One that takes longer than half of it is rare,
    # and ends after it: to wait for it in each call would leave no time for any.
    longest = max((row.cpu_s for row in rows), default=FIRST_GUESS)
    limit = 60.0 * args.minutes - min(longest, 30.0 * args.minutes)
    there = {row.number for row in rows}
    version, commit = _version()
    # as many as no call can get through: each takes a second and more
    many = range(1, len(there) + int(60.0 * args.minutes * args.workers) + 1)
    tasks = [(rigs, n, args.name, commit, version) for n in many if n not in there]
    about = argparse.Namespace(
        ledger=ledger, limit_s=limit, executor=args.executor, workers=args.workers
    )
    found, status = extended("blind pool", about, look, tasks)
    added = f"{len(found)} added, {len(there) + len(found)} rigs in all"
    print(f"blind: {added}; the same call adds more.")
    return status


def _version() -> tuple[str, str | None]:
    """Digest of what a diagnosis computes, and the commit if the package is as it has it."""

    def git(*words: str) -> str:
        asked = subprocess.run(("git", "-C", ROOT, *words), capture_output=True, text=True)
        return asked.stdout.strip() if asked.returncode == 0 else "?"

    try:
        clean = git("status", "--porcelain", "--", "tp_jax", "trials/*.py") == ""
        commit = git("rev-parse", f"--short={DIGITS}", "HEAD") if clean else None
    except OSError:  # no git here
        commit = None
    return computed()[:DIGITS], commit


def seed_of(name: str) -> int:
    """Seed of a pool: of another name, other rigs."""
    return zlib.crc32(name.encode())


def look(rigs: str, number: int, name: str, commit: str | None, version: str) -> Row:
    """One rig: made, diagnosed as if nobody knew it, and asked on its sealed runs."""
    from trials.case import Settings, make_case
    from trials.growing import rig
    from trials.rough import RoughSettings

    case = rig(number, seed_of(name), rigs)
    root = FOLDER / name / case.name
    shutil.rmtree(root, ignore_errors=True)  # of a call that was cut off
    root.mkdir(parents=True)
    entry = make_case(root, case, RoughSettings() if rigs == "rough" else Settings())
    begin = time.process_time()
    diagnosis, sealed = diagnosed(root, entry)
    spent = round(time.process_time() - begin, 1)
    unchanged(version)
    shutil.rmtree(root)
    return row_of(entry, diagnosis, sealed, number, case.seed, rigs, commit, version, spent)


def diagnosed(
    root: Path, entry: Mapping[str, Any], without: Sequence[str] = ()
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The diagnosis of a case, and what it is worth on the sealed runs.

    Args:
        root: of the case's trial. entry: its part of the key. without: as of `tp.diagnose`.
    """
    from scripts._blind.run import diagnose_case, wants_shrink
    from trials.harm import measured_harm
    from trials.seal import read_diagnosis
    from trials.sealed_runs import measured

    diagnose_case(root, entry["case"], without)
    diagnosis = read_diagnosis(root, entry)
    shrink = dict(measured(root, entry, diagnosis)) if wants_shrink(entry) else {}
    harm = measured_harm(root, entry, diagnosis)
    return diagnosis, {
        "shrink": shrink.get("shrink"),
        "best": shrink.get("best"),
        "harm_windowed": harm["windowed"],
        "harm_free_run": harm["free_run"],
    }


def row_of(
    entry: Mapping[str, Any],
    diagnosis: Mapping[str, Any],
    sealed: dict[str, Any],
    number: int,
    seed: int,
    rigs: str,
    commit: str | None,
    version: str,
    cpu_s: float,
) -> Row:
    """The line of a rig."""
    from trials.judge import judge

    judged = judge(entry, diagnosis)
    first = judged["first"] or {}
    return Row(
        number=number,
        seed=seed,
        rigs=rigs,
        kind=entry["kind"],
        version=version,
        commit=commit,
        hidden={
            id: {
                "sizes": list(each["sizes"].values()),
                "multiple": entry["reference"][id]["multiple"],
            }
            for id, each in entry["given"]["effects"].items()
        },
        detectable=judged["multiple"],
        verdict=judged["verdict"],
        causes=judged["causes"],
        shrink=(diagnosis.get("gap") or {}).get("shrink"),
        probability=first.get("probability"),
        sealed=sealed,
        judged={k: x for k, x in judged.items() if k not in KNOWN},
        cpu_s=cpu_s,
    )


def judged_of(row: Row) -> dict[str, Any]:
    """A line as `trials.score` takes it."""
    windowed, free = row.sealed["harm_windowed"], row.sealed["harm_free_run"]
    known = [x for x in (windowed, free) if x is not None]
    shrink = {"shrink": row.sealed["shrink"], "best": row.sealed["best"]}
    return {
        **row.judged,
        "case": f"{row.rigs}-{row.number:05d}",
        "kind": row.kind,
        "effects": list(row.hidden),
        "multiple": row.detectable,
        "verdict": row.verdict,
        "causes": row.causes,
        "harm_windowed": windowed,
        "harm_free_run": free,
        "harm": any(known) if known else None,
        **({"shrink": shrink} if row.kind in ("one", "two") else {}),
    }


def by_version(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """A line of `HEADS` for each version, in the order in which they were tried."""
    from trials.score import summary
    from trials.table import measure

    lines = []
    for version in dict.fromkeys(row.version for row in rows):
        mine = [row for row in rows if row.version == version]
        found = summary([judged_of(row) for row in mine])
        commits = dict.fromkeys(row.commit or "none" for row in mine)
        asked = (
            found["top1"],
            found["from_3"]["top1"],
            found["false_alarm"],
            found["unknown"],
            found["harm"],
        )
        spent = sum(row.cpu_s for row in mine) / len(mine)
        lines.append(
            (version, " ".join(commits), str(len(mine)), *map(measure, asked), f"{spent:.0f}")
        )
    return lines


def shown(args: argparse.Namespace, rows: Sequence[Row]) -> None:
    """Prints the pool by version; with --score all tables of one version too."""
    from trials.score import summary
    from trials.table import Sheet, sheets

    title = f"the pool {args.name}, {rows[0].rigs} rigs, by version of the program"
    pages = [Sheet(title, HEADS, by_version(rows))]
    if args.score:
        version = args.version or rows[-1].version
        mine = [row for row in rows if row.version.startswith(tuple(version.split(",")))]
        if not mine:
            raise InputError(f"The pool {args.name} has no rigs of the version {version}.")
        scored = summary([judged_of(row) for row in mine])
        pages += sheets({"cases": len(mine), **scored})
    told = "\n\n".join(f"{s.title}:\n\n{markdown.table(s.heads, s.rows)}" for s in pages)
    print(told)
    if args.markdown is not None:
        from tp_jax.cli.output import write_text

        write_text(Path(args.markdown), told + "\n")
