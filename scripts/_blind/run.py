"""scripts/blind run: a blind trial made, diagnosed and scored, resumably."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from scripts import _markdown as markdown
from tp_jax.cli.arguments import add_executor, count, executor_of, positive, whole
from tp_jax.errors import InputError
from tp_jax.executors import ExecutorChoice, Piece, run_pieces

LAST = 12  # tasks of a process; its compiled programs add up


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds `run`."""
    parser = commands.add_parser(
        "run",
        help="make a trial, diagnose every case and score, resumably",
        description="A blind trial: made if it is not there, diagnosed, scored. Resumes.",
    )
    parser.add_argument(
        "directory",
        metavar="DIR",
        nargs="?",
        default="blind-trial",
        help="of the trial (default ./blind-trial)",
    )
    parser.add_argument("--cases", metavar="N", type=count, help="of a new trial (default 440)")
    parser.add_argument(
        "--rigs",
        choices=("clean", "rough"),
        help="of a new trial, as `scripts/blind make --rigs` (default clean)",
    )
    parser.add_argument("--seed", metavar="N", type=whole, help="of a new trial (default 0)")
    add_executor(parser)
    parser.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no case after so many seconds; what is known is scored once all are diagnosed",
    )
    parser.add_argument(
        "--first", metavar="N", type=count, help="of the cases; the others are given up"
    )
    parser.add_argument(
        "--pool",
        metavar="F",
        action="append",
        default=[],
        help="score.json of another trial of the same program, for the tables (repeatable)",
    )
    parser.add_argument("--quick", action="store_true", help="as `scripts/blind score --quick`")
    parser.add_argument("--json", metavar="F", help="of the score (default DIR/score.json)")
    parser.add_argument("--markdown", metavar="F", help="gets the tables, replacing it")
    parser.add_argument(
        "--debug",
        action="store_true",
        default=argparse.SUPPRESS,
        help="show the traceback of a fault",
    )
    parser.set_defaults(run=run_trial)


def run_trial(args: argparse.Namespace) -> int:
    """Exit code."""
    from tp_jax.cli.output import ready, write_json, write_text
    from tp_jax.cli.progress import shown
    from trials import make, pool, score
    from trials.seal import open_key, undiagnosed

    ready(args.json, args.markdown)
    others = [_read(path) for path in args.pool]
    begin, root = time.monotonic(), Path(args.directory)
    asked_for = any(given is not None for given in (args.cases, args.rigs, args.seed))
    if asked_for and (root / "KEY.sha256").is_file():
        print(
            f"blind: {root} holds a trial, which goes on with the cases, rigs and seed that it was "
            "made with; name another folder for another one.",
            file=sys.stderr,
        )
    with shown(quiet=False) as progress:
        if not (root / "KEY.sha256").is_file():
            make(
                root,
                args.cases or 440,
                args.seed or 0,
                rigs=args.rigs or "clean",
                executor=executor_of(args),
                progress=progress,
            )
        left, executor = undiagnosed(root, args.first), executor_of(args)
        until = begin + args.limit_s
        failed = _done(
            diagnose_case,
            [(root, name) for name in left],
            executor,
            until,
            lambda part: progress("diagnosing", part),
        )
    left = undiagnosed(root, args.first)
    for name, fault in failed.items():
        print(f"blind: the diagnosis of {name} failed: {fault}", file=sys.stderr)
    if left:
        print(f"blind: {len(left)} cases are without a diagnosis; the same call goes on.")
        return 1 if failed else 0
    key = open_key(root, args.first)  # opened from here on
    entries = key["cases"]
    shrinks, harms = (None, None) if args.quick else (_known_shrink, _known_harm)
    with shown(quiet=False) as progress:
        if not args.quick:
            asked = [(root, e["case"], e) for e in entries if _on_sealed(root, e)]
            failed = _done(
                _predict,
                asked,
                executor,
                until,
                lambda part: progress("predicting the sealed runs", part),
            )
            for name, fault in failed.items():
                print(f"blind: the sealed runs of {name}: {fault}", file=sys.stderr)
            todo = [task for task in asked if _waits(*task)]
            if todo and time.monotonic() > until:
                print(
                    f"blind: the sealed runs of {len(todo)} cases wait, and shrinks and harm are "
                    "those of the others; the same call goes on."
                )
        scored = score(root, shrinks=shrinks, harms=harms, first=args.first, progress=progress)
    write_json(args.json or root / "score.json", scored)
    if others:
        scored = pool([*others, scored])
    if args.markdown is not None:
        write_text(Path(args.markdown), _markdown(scored, key["seed"]))
    if args.json != "-":
        from rich.console import Console

        from trials.table import tables

        Console().print(tables(scored))
    return 1 if failed else 0


def _read(path: str) -> dict[str, Any]:
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise InputError(f"{path} is no score of a trial: {fault}.") from fault


def _markdown(scored: dict[str, Any], seed: int) -> str:
    from trials.table import sheets

    parts = [f"{s.title}:\n\n{markdown.table(s.heads, s.rows)}" for s in sheets(scored)]
    return "\n\n".join([*parts, markdown.circumstances(seed)]) + "\n"


def _done(
    work: Callable[..., None],
    tasks: Sequence[tuple],
    executor: ExecutorChoice,
    until: float,
    progress: Callable[[float], None],
) -> dict[str, str]:
    """Each task (root, case, ...), whose work writes its own result; faults by case."""
    failed: dict[str, str] = {}
    progress(0.0)
    pieces = [Piece(task[1], task) for task in tasks]
    ended = run_pieces(work, pieces, executor, until=until, pieces_per_worker=LAST)
    for done, each in enumerate(ended, start=1):
        if each.fault is not None:
            failed[each.piece.key] = str(each.fault)
        progress(done / len(tasks))
    return failed


def diagnose_case(root: Path, name: str, without: Sequence[str] = ()) -> None:
    """Writes the diagnosis of a case beside it, made with the defaults but for `without`."""
    import tp_jax as tp
    from tp_jax.cli.output import write_json
    from trials.seal import diagnosis_file

    diagnosis = tp.diagnose(tp.load_campaign(root / name), without=without)
    write_json(diagnosis_file(root, name), diagnosis.to_dict())


def _sealed(root: Path, name: str) -> Path:
    from trials.seal import diagnosis_file

    return diagnosis_file(root, name).with_name("sealed.json")


def wants_shrink(entry: Mapping[str, Any]) -> bool:
    """True if the model of a case is asked how far it closes the gap."""
    return entry["kind"] in ("one", "two")


def _wants_harm(root: Path, entry: dict[str, Any]) -> bool:
    from trials.harm import asked
    from trials.seal import read_diagnosis

    return asked(read_diagnosis(root, entry))


def _on_sealed(root: Path, entry: dict[str, Any]) -> bool:
    """True if the sealed runs of a case are to be predicted."""
    return wants_shrink(entry) or _wants_harm(root, entry)


def _waits(root: Path, name: str, entry: dict[str, Any]) -> bool:
    """True if they have not been predicted, as far as they are to be."""
    from trials.harm import kept_file

    shrink = wants_shrink(entry) and not _sealed(root, name).is_file()
    return shrink or (_wants_harm(root, entry) and not kept_file(root, name).is_file())


def _predict(root: Path, name: str, entry: dict[str, Any]) -> None:  # noqa: ARG001
    from trials.harm import measured_harm
    from trials.seal import read_diagnosis
    from trials.sealed_runs import measured

    diagnosis = read_diagnosis(root, entry)
    if wants_shrink(entry):
        measured(root, entry, diagnosis)
    measured_harm(root, entry, diagnosis)


def _known_harm(root: Path, entry: Any, diagnosis: Any) -> dict[str, Any]:
    """Reads what `_predict` has left of the harm."""
    from trials.harm import NOTHING, kept_file, measured_harm

    if not kept_file(root, entry["case"]).is_file():
        return dict(NOTHING)
    return measured_harm(root, entry, diagnosis)


def _known_shrink(root: Path, entry: Any, diagnosis: Any) -> dict[str, float | None]:
    """Reads what `_predict` has left; a case in which it failed or that waits is not counted."""
    if not _sealed(root, entry["case"]).is_file():
        return {"shrink": None, "best": None}
    from trials.sealed_runs import measured

    return dict(measured(root, entry, diagnosis))
