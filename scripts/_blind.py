"""What scripts/blind runs: a blind trial made, diagnosed and scored, resumably."""

import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from tp_jax.cli.arguments import Parser, add_seed, count, positive
from tp_jax.cli.faults import explain

LAST = 12  # tasks of a process; its compiled programs add up


def main(argv: Sequence[str] | None = None) -> int:
    args = _parser().parse_args(argv)
    try:
        return _trial(args)
    except KeyboardInterrupt:
        print("blind: interrupted; the same call goes on from here.", file=sys.stderr)
        return 130
    except Exception as fault:
        return explain(fault, debug=args.debug)


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
                        help="begin no case after so many seconds")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="as `tp-jax blind score --quick`")
    parser.add_argument("--json", metavar="F", help="of the score (default DIR/score.json)")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _trial(args: Any) -> int:
    from tp_jax.blind import make, score
    from tp_jax.blind.seal import open_key, undiagnosed
    from tp_jax.cli.output import write_json
    from tp_jax.cli.progress import shown

    begin, root = time.monotonic(), Path(args.directory)
    with shown(quiet=False) as progress:
        if not (root / "KEY.sha256").is_file():
            make(root, args.cases, args.seed, workers=args.workers, progress=progress)
        left, workers = undiagnosed(root), args.workers
        until = begin + args.limit_s
        failed = _over_all_cores(
            _diagnose, [(root, name) for name in left], workers, until,
            lambda part: progress("diagnosing", part),
        )  # fmt: skip
    left = undiagnosed(root)
    for name, fault in failed.items():
        print(f"blind: the diagnosis of {name} failed: {fault}", file=sys.stderr)
    if left:
        print(f"blind: {len(left)} cases are without a diagnosis; the same call goes on.")
        return 1 if failed else 0
    entries = open_key(root)["cases"]  # opened from here on
    shrinks = None if args.quick else _known_shrink
    with shown(quiet=False) as progress:
        if not args.quick:
            hidden = [(root, e["case"], e) for e in entries if e["kind"] in ("one", "two")]
            failed = _over_all_cores(
                _shrink, hidden, workers, until,
                lambda part: progress("predicting the sealed runs", part),
            )  # fmt: skip
            for name, fault in failed.items():
                print(f"blind: the sealed runs of {name}: {fault}", file=sys.stderr)
            todo = [h for h in hidden if not _sealed(root, h[1]).is_file()]
            if todo and time.monotonic() > until:
                print(f"blind: the sealed runs of {len(todo)} cases wait; the same call goes on.")
                return 0
        scored = score(root, shrinks=shrinks, progress=progress)
    write_json(args.json or root / "score.json", scored)
    if args.json != "-":
        from rich.console import Console

        from tp_jax.blind.table import tables

        Console().print(tables(scored))
    return 1 if failed else 0


def _over_all_cores(
    work: Callable[..., None],
    tasks: Sequence[tuple],
    workers: int,
    until: float,
    progress: Callable[[float], None],
) -> dict[str, str]:
    """Each task in one of some processes, none begun after `until`; faults by case.

    Processes last for `LAST` tasks.

    Tasks are (root, case, ...).
    """
    failed: dict[str, str] = {}
    context = multiprocessing.get_context("spawn")
    queue, done = list(tasks)[::-1], 0
    while queue and time.monotonic() <= until:
        left = min(workers * LAST, len(queue))
        processors = context.Queue()
        for i in range(workers):
            processors.put(i)
        with ProcessPoolExecutor(workers, context, _begin, (processors,)) as pool:
            running: dict[Future, tuple] = {}
            progress(done / len(tasks))
            while left or running:
                # no more in hand than run, or those in hand would begin after `until`
                while left and len(running) < workers and time.monotonic() <= until:
                    task = queue.pop()
                    left -= 1
                    running[pool.submit(work, *task)] = task
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    task = running.pop(future)
                    fault = future.exception()
                    if fault is not None:
                        failed[task[1]] = f"{type(fault).__name__}: {fault}"
                    done += 1
                    progress(done / len(tasks))
    return failed


def _begin(processors: Any) -> None:
    """A worker: on one processor, which JAX then takes for the whole machine."""
    mine = processors.get()
    if hasattr(os, "sched_setaffinity"):
        allowed = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {allowed[mine % len(allowed)]})
    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache

    _ = tp.simulate  # the first name that computes sets 64 bits
    enable_compilation_cache()


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
    """What `_shrink` has left; a case in which it failed is not counted, and told of above."""
    if not _sealed(root, entry["case"]).is_file():
        return {"shrink": None, "best": None}
    from tp_jax.blind.sealed_runs import measured

    return dict(measured(root, entry, diagnosis))


if __name__ == "__main__":
    sys.exit(main())
