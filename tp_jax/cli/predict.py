"""tp-jax predict: what a run never seen will look like, by a diagnosis's model."""

import argparse
from pathlib import Path

from tp_jax.cli.arguments import add_common, add_overwrite, angle, frequency, positive, sample_count
from tp_jax.cli.output import ready, write_trajectory
from tp_jax.errors import InputError


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "predict",
        help="predict a run never seen",
        description="Free run of a diagnosis's model, written as CSV.",
    )
    parser.add_argument("diagnosis", metavar="DIAGNOSIS.json", help="written by tp-jax diagnose")
    run_of = parser.add_mutually_exclusive_group(required=True)
    run_of.add_argument("--omega", metavar="W", type=frequency, help="driven at W rad/s, from rest")
    run_of.add_argument(
        "--phi1", metavar="X", type=angle, help="released at X rad with the motor at rest"
    )
    run_of.add_argument(
        "--recording",
        metavar="FILE",
        help="driven as this file of a campaign was; then --duration and --rate may be left out",
    )
    parser.add_argument("--duration", metavar="S", type=positive, help="seconds")
    parser.add_argument("--rate", metavar="HZ", type=positive, help="samples a second")
    parser.add_argument(
        "--model",
        choices=("before", "after"),
        help="without or with the effects found (default after; before where none was found)",
    )
    parser.add_argument("--out", metavar="F.csv", help="default: standard output")
    add_overwrite(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    if args.recording is None:
        for name in ("duration", "rate"):
            if getattr(args, name) is None:
                raise InputError(f"Argument --{name} is needed unless --recording is given.")
    if args.duration is not None and args.rate is not None:
        sample_count(args.duration, args.rate)
    ready(args.out, overwrite=args.overwrite)

    from tp_jax.results.diagnosis import DiagnosisRecord

    diagnosis = DiagnosisRecord.from_json(Path(args.diagnosis)).to_dict()
    if args.recording is not None:
        _check_length(args)

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache

    enable_compilation_cache()
    trajectory = tp.predict(
        diagnosis,
        omega=args.omega,
        phi1=args.phi1,
        recording=args.recording,
        duration=args.duration,
        rate=args.rate,
        model=args.model,
    )
    write_trajectory(args.out, trajectory)
    if args.out not in (None, "-") and not args.quiet:
        print(f"Wrote {args.out}")


def _check_length(args: argparse.Namespace) -> None:
    """Sees that what is not given, and taken from the recording, makes a run that can be had."""
    if args.duration is None and args.rate is None:
        return

    import numpy as np

    from tp_jax.recordings.lookup import recording_of

    data = recording_of(args.recording)
    own = 1.0 / float(np.median(np.diff(data.t)))
    sample_count(args.duration or data.duration, args.rate or own)
