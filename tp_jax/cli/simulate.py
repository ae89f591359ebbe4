"""tp-jax simulate: runs the forward model of a preset from rest."""

import argparse

from tp_jax.cli.arguments import add_common, positive, sample_count
from tp_jax.cli.output import ready, replaced, write_trajectory
from tp_jax.errors import InputError

PRESETS = ("paper-5.1", "paper-5.1-start", "bench")
"""As in `tp_jax.model.presets`, which would bring JAX with it; a test holds the two together."""


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "simulate",
        help="run the forward model",
        description="Runs the model of a preset from rest and writes t,phi1,phi2 as CSV.",
    )
    parser.add_argument(
        "--preset", choices=PRESETS, default=PRESETS[0], help=f"default {PRESETS[0]}"
    )
    parser.add_argument(
        "--duration", metavar="S", type=positive, default=10.0, help="seconds (default 10)"
    )
    parser.add_argument(
        "--rate", metavar="HZ", type=positive, default=250.0, help="samples a second (default 250)"
    )
    parser.add_argument("--out", metavar="FILE.csv", help="default: standard output")
    parser.add_argument("--plot", metavar="FILE.png", help="draw angles and relative velocity")
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    samples = sample_count(args.duration, args.rate)
    ready(args.out, args.plot)

    import numpy as np

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache

    enable_compilation_cache()
    times = np.linspace(0.0, args.duration, samples)
    trajectory = tp.simulate(tp.presets.get(args.preset), times)

    if not np.isfinite(trajectory.phi1).all():
        raise InputError(
            f"A run of {args.duration:g} s takes more steps than the solver may; ask for a shorter "
            "--duration."
        )

    if args.plot is not None:
        from tp_jax.report.trajectory import plot_trajectory

        with replaced(args.plot) as part:
            plot_trajectory(trajectory, part, title=args.preset)
    if args.out is not None or args.plot is None:
        write_trajectory(args.out, trajectory)
    if not args.quiet:
        for written in (args.out, args.plot):
            if written is not None and written != "-":
                print(f"Wrote {written}")
