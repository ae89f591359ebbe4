"""tp-jax simulate: runs the forward model of a preset from rest."""

import argparse
from typing import Any

from tp_jax.cli.arguments import (
    add_common,
    add_overwrite,
    angle,
    figure_name,
    fixed,
    named,
    positive,
    sample_count,
)
from tp_jax.cli.output import ready, replaced, write_trajectory
from tp_jax.errors import InputError

PRESETS = ("paper-5.1", "paper-5.1-start", "bench")
"""Presets of `tp_jax.model.presets`, which would bring JAX with it; a test holds both together."""

COLUMN = ("B1", "k", "A", "omega", "c1", "M1", "eps", "phase")
"""Numbers of a column; as the arguments of `presets.single_pendulum`."""

RIDER = ("B2", "Tv", "Ts1", "Ts2", "Tst", "T0", "reaction")
"""Numbers that a rider adds to them."""

_ABOVE_ZERO = ("B1", "B2", "eps")
_ANY_SIGN = ("phase", "reaction", "A")


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "simulate",
        help="run the forward model",
        description="Runs the model of a preset, or of your own numbers, and writes t,phi1,phi2 "
        "as CSV.",
    )
    parser.add_argument(
        "--preset", choices=PRESETS, default=PRESETS[0], help=f"default {PRESETS[0]}"
    )
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        type=fixed,
        action="append",
        default=[],
        help=f"another number than the preset's, in SI units: {', '.join((*COLUMN, *RIDER))}; "
        "may be given often",
    )
    parser.add_argument(
        "--single", action="store_true", help="the column alone, without a rider: t,phi1"
    )
    parser.add_argument(
        "--phi1", metavar="X", type=angle, help="released at X rad with the motor at rest"
    )
    parser.add_argument(
        "--duration", metavar="S", type=positive, default=10.0, help="seconds (default 10)"
    )
    parser.add_argument(
        "--rate", metavar="HZ", type=positive, default=250.0, help="samples a second (default 250)"
    )
    parser.add_argument("--out", metavar="FILE.csv", help="default: standard output")
    add_overwrite(parser)
    parser.add_argument(
        "--plot",
        metavar="FILE.png",
        type=figure_name,
        help="draw angles and relative velocity; also .svg",
    )
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    samples = sample_count(args.duration, args.rate)
    numbers = _numbers(args)
    driven = [name for name in ("A", "omega", "phase") if name in numbers]
    if args.phi1 is not None and driven:
        raise InputError(
            f"Argument --set gives {driven[0]}, of the drive, but --phi1 lets the column go with "
            "the motor at rest; leave one of them out."
        )
    ready(args.out, args.plot, overwrite=args.overwrite)

    import numpy as np

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache

    enable_compilation_cache()
    times = np.linspace(0.0, args.duration, samples)
    values: dict[str, Any] = tp.presets.values(args.preset) | numbers
    if args.phi1 is not None:
        values["A"] = 0.0
    if args.single:
        model = tp.presets.single_pendulum(**{n: v for n, v in values.items() if n in COLUMN})
    else:
        model = tp.presets.double_pendulum(**values)
    trajectory = tp.simulate(model, times, np.array([args.phi1 or 0.0, 0.0, 0.0, 0.0]))
    if args.single:
        trajectory = trajectory._replace(phi2=None)

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


def _numbers(args: argparse.Namespace) -> dict[str, float]:
    """Reads the numbers that --set gives.

    Raises:
        InputError: a name that is none, or a value that cannot be.
    """
    known = COLUMN if args.single else (*COLUMN, *RIDER)
    numbers = named(args.set, "--set")
    for name, value in numbers.items():
        if name not in known:
            rider = " without a rider" if args.single else ""
            raise InputError(
                f"Argument --set names {name}, but a pendulum{rider} has {', '.join(known)}."
            )
        if name in _ABOVE_ZERO and value <= 0.0:
            raise InputError(f"Argument --set must give {name} above zero, but gives {value:g}.")
        if name not in _ANY_SIGN and value < 0.0:
            raise InputError(f"Argument --set must not give {name} below zero, as {value:g} is.")
    return numbers
