"""tp-jax sensitivity: which parameters matter, when, and which can be known at all."""

import argparse

from tp_jax.cli.arguments import (
    add_campaign,
    add_common,
    add_json,
    add_progress,
    add_seed,
    check_parameters,
    check_profiles,
    fixed,
    load,
    named,
    number,
    whole,
)
from tp_jax.cli.output import made_folder, ready, write_json

MODELS = ("newton", "paper")
MOST_SPREAD = 100.0
"""Limit of `tp_jax.model.plausible`, which would bring NumPy; a test holds the two together."""

MOST_SAMPLES = 2**16


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "sensitivity",
        help="identifiability, local and global sensitivity",
        description=(
            "Which parameters can be known from a campaign, structurally and given its noise, and "
            "which matter when: derivatives through time, Sobol' indices, elementary effects."
        ),
    )
    add_campaign(parser)
    parser.add_argument(
        "--model",
        choices=MODELS,
        default=MODELS[0],
        help="newton: contact torques in balance (default); paper: the equations as printed",
    )
    parser.add_argument(
        "--fix",
        metavar="NAME=V",
        type=fixed,
        action="append",
        default=[],
        help="hold a parameter at a value (repeatable)",
    )
    parser.add_argument(
        "--spread",
        metavar="F",
        type=spread,
        help="global indices: parameters from the fit's value over F to it times F (default 1.25)",
    )
    parser.add_argument(
        "--samples",
        metavar="N",
        type=power_of_two,
        help="points of the Sobol' sequence, a power of two (default 256)",
    )
    parser.add_argument(
        "--profile",
        metavar="NAME",
        action="append",
        default=[],
        help="likelihood profile of a parameter, or of all (repeatable; takes a while)",
    )
    parser.add_argument("--out", metavar="DIR", help="gets the figures as PNG")
    add_seed(parser)
    add_json(parser)
    add_progress(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def spread(text: str) -> float:
    """A factor above 1."""
    value = number(text)
    if not 1.0 < value <= MOST_SPREAD:
        raise argparse.ArgumentTypeError(
            f"must be a factor above 1 and at most {MOST_SPREAD:g}, but is {text}"
        )
    return value


def power_of_two(text: str) -> int:
    """A power of two from 2 to `MOST_SAMPLES`."""
    value = whole(text, least=2, most=MOST_SAMPLES)
    if value & (value - 1):
        raise argparse.ArgumentTypeError(f"must be a power of two, but is {value}")
    return value


def run(args: argparse.Namespace) -> None:
    fix = named(args.fix, "--fix")
    check_profiles(args.profile, fix)
    ready(args.json)
    campaign = load(args, args.campaign)
    check_parameters(campaign, fix)

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache
    from tp_jax.cli.progress import shown

    if args.out is not None:
        ready(made_folder(args.out) / "sobol.png")
    enable_compilation_cache()
    chosen = {"spread": args.spread, "samples": args.samples}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    with shown(quiet=args.quiet, form=args.progress) as progress:
        found = tp.sensitivity(
            campaign,
            model=args.model,
            fix=fix,
            profile=tuple(args.profile),
            seed=args.seed,
            progress=progress,
            **chosen,
        )
        if args.json is not None:
            write_json(args.json, found.to_dict())
        written = []
        if args.out is not None:
            from tp_jax.report.sensitivity import write_figures

            progress("drawing", None)
            written = write_figures(found, args.out)
    if args.json != "-" and not args.quiet:
        print(found.summary())
        if written:
            print(f"\nFigures: {', '.join(str(path) for path in written)}")
