"""tp-jax init: a campaign.toml from a folder of data files, to be corrected."""

import argparse
import shlex
import warnings
from pathlib import Path

from tp_jax.cli.arguments import add_common
from tp_jax.cli.output import ready, write_text
from tp_jax.errors import InputError, Notice


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "init",
        help="write a campaign.toml for a folder of data files",
        description=(
            "Looks at the data files of a folder and writes a campaign.toml with what it finds: "
            "delimiter, decimal sign, columns, units, counts of an encoder, how each run seems to "
            "have been driven. All of it is to be read and corrected."
        ),
    )
    parser.add_argument("folder", metavar="FOLDER", help="with a data file for each run")
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    folder = Path(args.folder)
    target = folder / "campaign.toml"
    if not folder.is_dir():
        raise InputError(f"{args.folder} is no folder; name the one with the data files.")
    if target.exists():
        raise InputError(f"{target} is there already; correct it, or move it away.")
    ready(target)

    from tp_jax.checks.proposal import propose

    text, told = propose(folder)
    for each in told:
        warnings.warn(each, Notice, stacklevel=2)
    write_text(target, text)
    if not args.quiet:
        print(text, end="")
        then = f"tp-jax check {shlex.quote(args.folder)}"
        print(f"Wrote {target}. Read and correct it, then run: {then}")
