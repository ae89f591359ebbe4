"""scripts/blind make and scripts/blind score: a sealed trial of the diagnosis, made and scored."""

import argparse
from pathlib import Path

from tp_jax.cli.arguments import (
    add_common,
    add_executor,
    add_json,
    add_progress,
    add_seed,
    count,
    executor_of,
    whole,
)

MOST_CASES = 100_000
"""Cases of a trial at most: a month of making them, and longer to diagnose them."""


def add_parsers(commands: argparse._SubParsersAction) -> None:
    """Adds `make` and `score`."""
    make = commands.add_parser(
        "make",
        help="make a trial",
        description="Makes DIR/case-001 and so on, and a sealed key; DIR/KEY.sha256 commits to it. "
        "Of 440 cases 200 hide one effect of the catalogue, 120 none, 60 one from outside it, 60 "
        "two. Of 360 rough ones 120 hide one, 90 none, 90 one of a known kind with another "
        "formula, 30 one from outside, 30 two.",
    )
    make.add_argument("directory", metavar="DIR", help="where to; must be empty or not there")
    make.add_argument(
        "--cases", metavar="N", type=cases, default=440, help="how many (default 440)"
    )
    make.add_argument(
        "--rigs",
        choices=("clean", "rough"),
        default="clean",
        help="clean: all alike, 6 runs of 10 s at 250 Hz (default); rough: rates, lengths, noise, "
        "converters, drives and numbers differ from case to case",
    )
    add_executor(make)
    add_seed(make)
    add_progress(make)
    add_common(make)
    make.set_defaults(run=run_make)

    score = commands.add_parser(
        "score",
        help="open the key and score the diagnoses",
        description="Scores DIR/case-001-diagnosis/diagnosis.json and so on. The key stays sealed "
        "until all of them are there.",
    )
    score.add_argument("directory", metavar="DIR", help="a trial, every case of it diagnosed")
    score.add_argument(
        "--quick",
        action="store_true",
        help="take the shrink from each diagnosis instead of from runs that were never given, and "
        "leave out the harm on those",
    )
    score.add_argument(
        "--first",
        metavar="N",
        type=count,
        help="score the first N cases and give up the others, which are not diagnosed",
    )
    add_json(score)
    add_progress(score)
    add_common(score)
    score.set_defaults(run=run_score)


def cases(text: str) -> int:
    """A number of cases."""
    return whole(text, least=1, most=MOST_CASES)


def run_make(args: argparse.Namespace) -> int:
    """Exit code."""
    from tp_jax.cli.output import made_folder

    # before anything is loaded; the trial grows beside its place
    made_folder(Path(args.directory).resolve().parent)

    from tp_jax.cli.progress import shown
    from trials import make

    with shown(quiet=args.quiet, form=args.progress) as progress:
        digest = make(
            args.directory,
            args.cases,
            args.seed,
            rigs=args.rigs,
            executor=executor_of(args),
            progress=progress,
        )
    if not args.quiet:
        print(f"Made {args.cases} cases in {args.directory}; SHA-256 of the key: {digest}")
    return 0


def run_score(args: argparse.Namespace) -> int:
    """Exit code."""
    from tp_jax.cli.output import ready, write_json
    from tp_jax.cli.progress import shown
    from trials import score
    from trials.seal import open_key

    ready(args.json)
    open_key(
        Path(args.directory), args.first
    )  # what is wrong is reported before anything heavy is loaded
    with shown(quiet=args.quiet, form=args.progress) as progress:
        shrinks, harms = (None, None) if args.quick else on_sealed_runs()
        scored = score(
            args.directory, shrinks=shrinks, harms=harms, first=args.first, progress=progress
        )
    if args.json is not None:
        write_json(args.json, scored)
    if args.json != "-" and not args.quiet:
        from rich.console import Console

        from trials.table import tables

        Console().print(tables(scored))
    return 0


def on_sealed_runs():
    """`sealed_runs.measured` and `harm.measured_harm`, once JAX is told how to compute."""
    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache

    _ = tp.simulate  # the first name that computes sets 64 bits
    enable_compilation_cache()

    from trials.harm import measured_harm
    from trials.sealed_runs import measured

    return measured, measured_harm
