"""tp-jax diagnose: where the gap lies, which effect causes it, how far it shrinks."""

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tp_jax.cli import fleet
from tp_jax.cli.arguments import (
    LARGEST_ANGLE,
    add_campaign,
    add_common,
    add_executor,
    add_json,
    add_parent,
    add_progress,
    add_seed,
    load,
    non_negative,
    up_to,
)
from tp_jax.cli.diagnosed import FITS, REPORT, default_folder, diagnosed
from tp_jax.cli.ending import end_with_standard_input
from tp_jax.cli.output import forget, ready, write_json
from tp_jax.errors import InputError

tolerance = up_to(non_negative, LARGEST_ANGLE, "rad")

EXAMPLE = Path(__file__).parent.parent / "examples" / "case-02"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "diagnose",
        help="find where the gap lies, what causes it, how far it shrinks",
        description=(
            "Diagnoses the gap between the model and a campaign of recordings; writes a report "
            "to be read and a diagnosis.json that `tp-jax predict` continues from. Several "
            "campaigns, or a folder of them, are a fleet: each is diagnosed in a folder of its own "
            "in DIR, which gets a table and a page of all of them."
        ),
        epilog=(
            f"Until the command ends, DIR/{FITS} keeps the fits that are done, also of a command "
            "that is killed; --resume goes on from there, to the same result. A fleet keeps each "
            "rig that is done in DIR/pieces; it ends with 0 if all rigs could be diagnosed, and "
            "else with 2 (a rig's input is to be mended) or 1 (a fault of ours)."
        ),
    )
    add_campaign(parser, default="the example that comes with the package", several=True)
    parser.add_argument(
        "--out", metavar="DIR", help="gets report.html and diagnosis.json (./NAME-diagnosis)"
    )
    parser.add_argument(
        "--figures",
        action="store_true",
        help="write the report's figures to DIR/figures too, each as PNG and SVG",
    )
    parser.add_argument(
        "--tolerance",
        metavar="X",
        type=tolerance,
        default=0.0,
        help="rad rms; a gap below it matters to nobody (0)",
    )
    parser.add_argument(
        "--without",
        metavar="EFFECT",
        action="append",
        default=[],
        help="id of an effect not to ask about, since you ruled it out (`tp-jax effects` lists "
        "them); may be given several times",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on from a diagnosis that was broken off"
    )
    of_fleet = parser.add_argument_group("of a fleet")
    of_fleet.add_argument(
        "--shared",
        action="store_true",
        help="ask which effects the rigs share that no rig may show alone; at least three rigs",
    )
    add_executor(of_fleet)
    add_seed(parser)
    add_json(parser)
    add_progress(parser)
    add_parent(parser)
    add_common(parser)
    parser.set_defaults(run=run)


@contextmanager
def _kept(file: Path, *, resume: bool) -> Iterator[None]:
    """Says how to go on from the file after Ctrl-C; takes it away where nothing leads on from it.

    Without --resume an earlier leftover is not looked at; it is replaced once the work begins, and
    stays where the command is refused before.
    """
    begun = time.time()

    def earlier() -> bool:
        return file.is_file() and file.stat().st_mtime < begun

    try:
        yield
    except KeyboardInterrupt:
        there = f"; what is done is kept in {file}, and the same command with --resume goes on"
        # an earlier leftover may be of other data
        mine = file.is_file() and (resume or not earlier())
        raise KeyboardInterrupt(f"Interrupted{there if mine else ''}.") from None
    except InputError:
        if not (resume or earlier()):
            forget(file)
        raise


def run(args: argparse.Namespace) -> int:
    if args.until_stdin_closes:
        end_with_standard_input()
    campaigns = fleet.campaigns_of(args.campaign)
    if campaigns is not None:
        return fleet.run(args, campaigns)
    if args.shared:
        raise InputError("--shared asks a fleet; give several campaigns, or a folder of them.")
    if args.out is not None:  # before what the recordings look like is reported
        ready(Path(args.out) / REPORT, args.json)
    campaign = load(args, args.campaign[0] if args.campaign else EXAMPLE)
    folder = default_folder(campaign.name) if args.out is None else Path(args.out)
    report = folder / REPORT
    ready(report, args.json)

    from tp_jax._config import enable_compilation_cache
    from tp_jax.cli.progress import shown

    enable_compilation_cache()
    kept = folder / FITS
    with shown(quiet=args.quiet, form=args.progress) as progress, _kept(kept, resume=args.resume):
        result = diagnosed(
            campaign,
            folder,
            seed=args.seed,
            tolerance=args.tolerance,
            without=args.without,
            figures=args.figures,
            resume=args.resume,
            progress=progress,
        )
    if args.json is not None:
        write_json(args.json, result)
    if args.json != "-" and not args.quiet:
        from tp_jax.report.terminal import show

        show(result)
        print(f"\nReport: {report}")
    return 0
