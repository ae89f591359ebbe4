"""tp-jax sensitivity: which parameters matter, when, and which can be known at all."""

import argparse

from tp_jax.cli.arguments import (
    add_campaign,
    add_common,
    add_json,
    add_seed,
    count,
    fixed,
    load,
    named,
    number,
)

MODELS = ("newton", "paper")


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
        type=number,
        help="global indices: parameters from the fit's value over F to it times F (default 1.25)",
    )
    parser.add_argument(
        "--samples",
        metavar="N",
        type=count,
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
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    fix = named(args.fix, "--fix")
    campaign = load(args, args.campaign)

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache
    from tp_jax.cli.output import made_folder, plain, ready, write_json
    from tp_jax.cli.progress import shown

    ready(args.json)
    if args.out is not None:
        from tp_jax.report.sensitivity.files import needed

        needed()
        made_folder(args.out)
    enable_compilation_cache()
    chosen = {"spread": args.spread, "samples": args.samples}
    chosen = {name: value for name, value in chosen.items() if value is not None}
    with shown(quiet=args.quiet) as progress:
        found = tp.sensitivity(
            campaign, model=args.model, fix=fix, profile=tuple(args.profile), seed=args.seed,
            progress=progress, **chosen,
        )  # fmt: skip
        result = plain(found.to_dict())
        written = []
        if args.out is not None:
            from tp_jax.report.sensitivity import write_figures

            progress("drawing", None)
            written = write_figures(result, args.out)
    if args.json is not None:
        write_json(args.json, result)
    if args.json != "-" and not args.quiet:
        print(found.summary())
        if written:
            print(f"\nFigures: {', '.join(str(path) for path in written)}")
