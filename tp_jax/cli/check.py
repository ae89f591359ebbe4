"""tp-jax check: all that is wrong or doubtful about a campaign, at once."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.cli.arguments import add_campaign, add_common, add_json, figure_name
from tp_jax.cli.faults import where_it_goes
from tp_jax.cli.output import ready, replaced, write_json
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.checks import Checked


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "check",
        help="list faults of recordings, and how to mend them",
        description=(
            "Reads a campaign and tells all faults at once: files, units, frequencies, encoders "
            "that start anew, angles measured against the base, sampling, clipping. Fits nothing. "
            "Exit code 2 where something is wrong; what is doubtful does not count."
        ),
    )
    add_campaign(parser)
    parser.add_argument(
        "--figure",
        metavar="FILE.png",
        type=figure_name,
        help="draw the angles and phi1's spectrum; also .svg",
    )
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    ready(args.figure, args.json, inputs=[args.campaign])

    from tp_jax.checks import check

    checked = check(args.campaign, omega=args.omega, decay=args.decay)
    if args.figure is not None and checked.campaign is not None:
        from tp_jax.report.recordings import draw_recordings

        with replaced(args.figure) as part:
            draw_recordings(checked, part, kind=Path(args.figure).suffix[1:].lower())
    if args.json is not None:
        write_json(args.json, checked.to_dict())
    if args.quiet and args.json != "-":
        for each in checked.wrong:  # faults are told all the same
            print(f"{each.level:9}{each.sentence}")
    elif args.json != "-":
        print("\n".join(_told(checked)))
        asked = " ".join(each.mend for each in checked.wrong + checked.doubtful)
        if goes := where_it_goes(args.campaign, asked):
            print(goes.lstrip())
        if args.figure is not None and checked.campaign is not None:
            print(f"Wrote {args.figure}")
    if checked.wrong:
        n = len(checked.wrong)
        what = "1 fault is" if n == 1 else f"{n} faults are"
        raise InputError(f"{what} to be mended before {args.campaign} can be used.")


def _told(checked: "Checked") -> list[str]:
    lines = [f"{each.level:9}{each.sentence}" for each in checked.findings]
    campaign = checked.campaign
    if campaign is None:
        return lines
    if checked.shares:
        n, least = len(checked.shares), min(int(100.0 * min(checked.shares.values())), 99)
        where = "the forced run" if n == 1 else f"each of {n} forced runs"
        lines.append(
            f"In {where} at least {least}% of phi1's motion is at the omega that is given, or at "
            "two harmonics of it."
        )
    n = len(campaign.recordings)
    read = f"{n} recording{'' if n == 1 else 's'} of {campaign.name} read"
    good = not (checked.wrong or checked.doubtful)
    return [*lines, f"{read}, nothing to mend." if good else f"{read}."]
