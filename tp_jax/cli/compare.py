"""tp-jax compare: two diagnoses side by side."""

import argparse
from pathlib import Path

from tp_jax.cli.arguments import add_common, add_json, file_name
from tp_jax.cli.output import ready, write_json, write_text


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "compare",
        help="set two diagnoses side by side",
        description=(
            "Sets two diagnoses side by side, as before and after a repair, or of two rigs: "
            "verdicts, gaps, causes with their sizes, parameters with their intervals."
        ),
    )
    for name in ("a", "b"):
        parser.add_argument(
            name, metavar=name.upper(), help="a diagnosis.json, or the folder that holds it"
        )
    parser.add_argument("--html", metavar="FILE.html", type=file_name, help="write a page as well")
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    files = [Path(each) for each in (args.a, args.b)]
    files = [each / "diagnosis.json" if each.is_dir() else each for each in files]
    ready(args.html, args.json, inputs=files)

    from tp_jax.report import comparison
    from tp_jax.results.diagnosis import DiagnosisRecord

    a, b = map(DiagnosisRecord.from_json, files)
    if args.json is not None:
        write_json(args.json, comparison.compared(a, b))
    if args.html is not None:
        write_text(args.html, comparison.page(a, b))
    if args.json != "-":
        print(comparison.text(a, b), end="")
        if args.html is not None and not args.quiet:
            print(f"Wrote {args.html}")
