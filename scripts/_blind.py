"""What scripts/blind runs: a blind trial made, diagnosed and scored, resumably."""

import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._workers import fault_of, over_all_cores
from tp_jax.cli.arguments import Parser, add_seed, count, positive
from tp_jax.errors import InputError

LAST = 12  # tasks of a process; its compiled programs add up


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("blind", _trial, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/blind",
        description="A blind trial: made if it is not there, diagnosed, scored. Resumes.",
    )
    parser.add_argument("directory", metavar="DIR", nargs="?", default="blind-trial",
                        help="of the trial (default ./blind-trial)")  # fmt: skip
    parser.add_argument("--cases", metavar="N", type=count, default=440, help="default 440")
    add_seed(parser)
    parser.add_argument("--workers", metavar="N", type=count, default=os.cpu_count() or 1,
                        help="processes (default: as many as processors)")  # fmt: skip
    parser.add_argument("--limit-s", metavar="S", type=positive, default=float("inf"),
                        help="begin no case after so many seconds; what is known is scored "
                        "once all are diagnosed")  # fmt: skip
    parser.add_argument("--first", metavar="N", type=count,
                        help="of the cases; the others are given up")  # fmt: skip
    parser.add_argument("--pool", metavar="F", action="append", default=[],
                        help="score.json of another trial of the same program, for the tables "
                        "(repeatable)")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="as `tp-jax blind score --quick`")
    parser.add_argument("--json", metavar="F", help="of the score (default DIR/score.json)")
    parser.add_argument("--markdown", metavar="F", help="gets the tables, replacing it")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _trial(args: Any) -> int:
    from tp_jax.blind import make, pool, score
    from tp_jax.blind.seal import open_key, undiagnosed
    from tp_jax.cli.output import ready, write_json, write_text
    from tp_jax.cli.progress import shown

    ready(args.json, args.markdown)
    others = [_read(path) for path in args.pool]
    begin, root = time.monotonic(), Path(args.directory)
    with shown(quiet=False) as progress:
        if not (root / "KEY.sha256").is_file():
            make(root, args.cases, args.seed, workers=args.workers, progress=progress)
        left, workers = undiagnosed(root, args.first), args.workers
        until = begin + args.limit_s
        failed = _done(
            _diagnose, [(root, name) for name in left], workers, until,
            lambda part: progress("diagnosing", part),
        )  # fmt: skip
    left = undiagnosed(root, args.first)
    for name, fault in failed.items():
        print(f"blind: the diagnosis of {name} failed: {fault}", file=sys.stderr)
    if left:
        print(f"blind: {len(left)} cases are without a diagnosis; the same call goes on.")
        return 1 if failed else 0
    entries = open_key(root, args.first)["cases"]  # opened from here on
    shrinks = None if args.quick else _known_shrink
    with shown(quiet=False) as progress:
        if not args.quick:
            hidden = [(root, e["case"], e) for e in entries if e["kind"] in ("one", "two")]
            failed = _done(
                _shrink, hidden, workers, until,
                lambda part: progress("predicting the sealed runs", part),
            )  # fmt: skip
            for name, fault in failed.items():
                print(f"blind: the sealed runs of {name}: {fault}", file=sys.stderr)
            todo = [h for h in hidden if not _sealed(root, h[1]).is_file()]
            if todo and time.monotonic() > until:
                print(
                    f"blind: the sealed runs of {len(todo)} cases wait, and the shrinks are those "
                    "of the others; the same call goes on."
                )
        scored = score(root, shrinks=shrinks, first=args.first, progress=progress)
    write_json(args.json or root / "score.json", scored)
    if others:
        scored = pool([*others, scored])
    if args.markdown is not None:
        write_text(Path(args.markdown), _markdown(scored, args.seed))
    if args.json != "-":
        from rich.console import Console

        from tp_jax.blind.table import tables

        Console().print(tables(scored))
    return 1 if failed else 0


def _read(path: str) -> dict[str, Any]:
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        raise InputError(f"{path} is no score of a trial: {fault}.") from fault


def _markdown(scored: dict[str, Any], seed: int) -> str:
    from tp_jax.blind.table import sheets

    parts = [f"{s.title}:\n\n{markdown.table(s.heads, s.rows)}" for s in sheets(scored)]
    return "\n\n".join([*parts, markdown.circumstances(seed)]) + "\n"


def _done(
    work: Callable[..., None],
    tasks: Sequence[tuple],
    workers: int,
    until: float,
    progress: Callable[[float], None],
) -> dict[str, str]:
    """Each task (root, case, ...) in one of some processes; faults by case."""
    failed: dict[str, str] = {}
    progress(0.0)
    for done, (task, future) in enumerate(
        over_all_cores(work, tasks, workers, until, last=LAST), start=1
    ):
        fault = fault_of(future)
        if fault is not None:
            failed[task[1]] = fault
        progress(done / len(tasks))
    return failed


def _diagnose(root: Path, name: str) -> None:
    import tp_jax as tp
    from tp_jax.blind.seal import diagnosis_file
    from tp_jax.cli.output import plain, write_json

    diagnosis = tp.diagnose(tp.load_campaign(root / name))
    write_json(diagnosis_file(root, name), plain(diagnosis.to_dict()))


def _sealed(root: Path, name: str) -> Path:
    from tp_jax.blind.seal import diagnosis_file

    return diagnosis_file(root, name).with_name("sealed.json")


def _shrink(root: Path, name: str, entry: dict[str, Any]) -> None:  # noqa: ARG001
    from tp_jax.blind.seal import read_diagnosis
    from tp_jax.blind.sealed_runs import measured

    measured(root, entry, read_diagnosis(root, entry))


def _known_shrink(root: Path, entry: Any, diagnosis: Any) -> dict[str, float | None]:
    """What `_shrink` has left; a case in which it failed or that waits is not counted."""
    if not _sealed(root, entry["case"]).is_file():
        return {"shrink": None, "best": None}
    from tp_jax.blind.sealed_runs import measured

    return dict(measured(root, entry, diagnosis))


if __name__ == "__main__":
    sys.exit(main())
