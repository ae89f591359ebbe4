"""tp-jax identify: fits the model's parameters to a campaign from several starts."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tp_jax.cli.arguments import (
    add_campaign,
    add_common,
    add_json,
    add_progress,
    add_seed,
    bounded,
    check_parameters,
    count,
    fixed,
    load,
    named,
    starts,
)
from tp_jax.cli.diagnose import default_folder
from tp_jax.cli.output import forget, ready, write_json

if TYPE_CHECKING:
    from tp_jax.estimation.identification import Identification

MODELS = ("newton", "paper")
METHODS = (
    "least-squares",
    "nelder-mead",
    "variable-projection",
    "levenberg-marquardt",
    "dogleg",
    "gauss-newton",
    "bfgs",
)
OBJECTIVES = ("windows", "free-run")
LOSSES = ("linear", "huber", "soft-l1", "cauchy")
SAMPLINGS = ("sobol", "latin-hypercube")
"""Samplings of `tp_jax.estimation`, which would bring JAX with it; a test holds both together."""

STARTS = "starts.json"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "identify",
        help="fit the model's parameters to a campaign",
        description="Multi-start identification of the model's parameters, with their intervals.",
        epilog=(
            "With several starts, those that are finished are kept in DIR (./NAME-identification) "
            "until the command ends; --resume goes on from there."
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
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help=f"default {METHODS[0]}; nelder-mead is the paper's, those after it run on optimistix",
    )
    parser.add_argument(
        "--objective",
        choices=OBJECTIVES,
        help="windows that grow (default), or whole runs, as nelder-mead takes them (17)",
    )
    parser.add_argument(
        "--loss", choices=LOSSES, default=LOSSES[0], help="of a residual; all but linear are robust"
    )
    parser.add_argument(
        "--noise",
        choices=("data", "fit"),
        default="data",
        help="where its level in each channel is taken from (default data)",
    )
    parser.add_argument("--starts", metavar="N", type=starts, help="number of starts")
    parser.add_argument(
        "--sampling",
        choices=SAMPLINGS,
        default=SAMPLINGS[0],
        help=f"how starts are spread over the bounds (default {SAMPLINGS[0]})",
    )
    parser.add_argument(
        "--raw-starts",
        action="store_true",
        help="begin at the drawn points themselves, without help of the data",
    )
    parser.add_argument(
        "--iterations", metavar="N", type=count, help="of nelder-mead, for each start (50)"
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
        "--bound",
        metavar="NAME=LO:HI",
        type=bounded,
        action="append",
        default=[],
        help="keep a parameter between two values (repeatable)",
    )
    parser.add_argument("--out", metavar="DIR", help="keep the starts there, and figures of them")
    parser.add_argument("--resume", action="store_true", help="go on from an interrupted search")
    add_seed(parser)
    add_json(parser)
    add_progress(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def folder_of(args: argparse.Namespace, name: str) -> Path:
    """Names the folder in which the starts of a campaign are kept."""
    if args.out is not None:
        return Path(args.out)
    return Path(f"{default_folder(name).name.removesuffix('diagnosis')}identification")


def run(args: argparse.Namespace) -> None:
    fix, bound = named(args.fix, "--fix"), named(args.bound, "--bound")
    ready(args.json)  # reported before the work rather than after it
    campaign = load(args, args.campaign)
    check_parameters(campaign, fix, bound)
    folder = folder_of(args, campaign.name)
    options = _options(args)
    if "checkpoint" in options:
        options["checkpoint"] = folder / STARTS
    ready(None if args.out is None else folder / STARTS)

    import tp_jax as tp
    from tp_jax._config import enable_compilation_cache
    from tp_jax.cli.progress import shown

    enable_compilation_cache()
    with shown(quiet=args.quiet, form=args.progress) as progress:
        result = tp.identify(
            campaign,
            model=args.model,
            method=args.method,
            fix=fix,
            bound=bound,
            seed=args.seed,
            progress=progress,
            **options,
        )
    if args.json is not None:
        write_json(args.json, result.to_dict())
    written = [] if args.out is None else _draw(result, folder)
    if args.out is None and "checkpoint" in options:
        forget(folder / STARTS)
    if args.json != "-" and not args.quiet:
        print(result.summary())
        for path in written:
            print(f"Wrote {path}")


def _options(args: argparse.Namespace) -> dict[str, Any]:
    """Collects what was asked for beyond the usual."""
    options: dict[str, Any] = {}
    if args.starts is not None:
        options["starts"] = args.starts
    if args.objective is not None:
        options["objective"] = args.objective
    if args.iterations is not None:
        options["iterations"] = args.iterations
    for name, usual in (("loss", LOSSES[0]), ("noise", "data"), ("sampling", SAMPLINGS[0])):
        if getattr(args, name) != usual:
            options[name] = getattr(args, name)
    for name in ("raw_starts", "resume"):
        if getattr(args, name):
            options[name] = True
    if args.resume or args.out is not None or (args.starts or 1) > 1:
        options["checkpoint"] = True  # its path follows
    return options


def _draw(result: "Identification", folder: Path) -> list[Path]:
    """Draws the starts into a folder; the files written."""
    from tp_jax.cli.output import replaced
    from tp_jax.report import style
    from tp_jax.report.starts import FIGURES

    written = []
    for name, figure in FIGURES.items():
        path = folder / f"{name}.png"
        with replaced(path) as part:
            style.save(figure(result), part)
        written.append(path)
    return written
