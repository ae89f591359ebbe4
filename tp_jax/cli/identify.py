"""tp-jax identify: fits the model's parameters to a campaign from several starts."""

import argparse

from tp_jax.cli.arguments import (
    add_campaign,
    add_common,
    add_json,
    add_seed,
    bounded,
    count,
    fixed,
    load,
    named,
)

MODELS = ("newton", "paper")
METHODS = ("least-squares", "nelder-mead")


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "identify",
        help="fit the model's parameters to a campaign",
        description="Multi-start identification of the model's parameters, with their intervals.",
    )
    add_campaign(parser)
    parser.add_argument(
        "--model",
        choices=MODELS,
        default=MODELS[0],
        help="newton: contact torques in balance (default); paper: the equations as printed",
    )
    parser.add_argument(
        "--method", choices=METHODS, default=METHODS[0], help=f"default {METHODS[0]}"
    )
    parser.add_argument("--starts", metavar="N", type=count, help="number of starts")
    parser.add_argument(
        "--fix",
        metavar="NAME=V",
        type=fixed,
        action="append",
        default=[],
        help="hold a parameter at a value (repeatable)",
    )
    parser.add_argument(
        "--bound",
        metavar="NAME=LO:HI",
        type=bounded,
        action="append",
        default=[],
        help="keep a parameter between two values (repeatable)",
    )
    add_seed(parser)
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    fix, bound = named(args.fix, "--fix"), named(args.bound, "--bound")
    campaign = load(args, args.campaign)

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache
    from tp_jax.cli.output import ready, write_json
    from tp_jax.cli.progress import shown

    ready(args.json)
    enable_compilation_cache()
    starts = {} if args.starts is None else {"starts": args.starts}
    with shown(quiet=args.quiet) as progress:
        result = tp.identify(
            campaign,
            model=args.model,
            method=args.method,
            fix=fix,
            bound=bound,
            seed=args.seed,
            progress=progress,
            **starts,
        )
    if args.json is not None:
        write_json(args.json, result.to_dict())
    if args.json != "-" and not args.quiet:
        print(result.summary())
