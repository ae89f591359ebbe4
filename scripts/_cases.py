"""Program of scripts/cases: diagnoses campaigns and prints one Markdown table of the results."""

import os
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from scripts._markdown import circumstances, row
from tp_jax.cli.arguments import Parser, add_seed
from tp_jax.cli.diagnose import EXAMPLE
from tp_jax.cli.output import ready, write_json
from tp_jax.errors import InputError
from tp_jax.report.formatting import MISSING, angle, number, percent, percents
from tp_jax.results.diagnosis import DiagnosisRecord

if TYPE_CHECKING:
    from tp_jax.recordings import Campaign

SHARED = Path(__file__).parent.parent.parent / "shared"

HEAD = (
    "campaign",
    "verdict",
    "causes",
    "shrink (95 % interval)",
    "windowed, before → after",
    "free run, before → after",
    "noise floor",
    "seconds",
)


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("cases", _table, _parser().parse_args(argv), resumes=False)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/cases",
        description="Diagnoses campaigns and prints one Markdown table of the results.",
    )
    parser.add_argument(
        "campaigns",
        metavar="CAMPAIGN",
        nargs="*",
        help="folders with a campaign.toml; default: the example that comes with the package and, "
        "where they exist, ../shared/examples/*, ../shared/data/multiarm and pohl_wheel",
    )
    parser.add_argument("--out", metavar="DIR", help="gets NAME.json of each campaign")
    add_seed(parser)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _table(args: Any) -> int:
    from tp_jax._config import enable_compilation_cache

    # all are read, and all places to write to seen, before minutes of work begin
    campaigns = _campaigns(args.campaigns)
    targets = _targets(args.out, campaigns)
    ready(*targets)

    import tp_jax as tp

    enable_compilation_cache()
    print(row(HEAD))
    print(row("---" for _ in HEAD), flush=True)
    for campaign, target in zip(campaigns, targets, strict=True):
        found = tp.diagnose(campaign, seed=args.seed)
        if target is not None:
            write_json(target, found.to_dict())
        print(row(_cells(found)), flush=True)
    print(f"\n{circumstances(args.seed)} Seconds include what had to be compiled.")
    return 0


def _campaigns(paths: Sequence[str]) -> "list[Campaign]":
    from tp_jax.recordings import load_campaign

    if paths:
        return [load_campaign(path) for path in paths]
    real = [SHARED / "data" / name for name in ("multiarm", "pohl_wheel")]
    found = [EXAMPLE, *sorted((SHARED / "examples").glob("*/")), *real]
    campaigns = [load_campaign(path) for path in found if (path / "campaign.toml").is_file()]
    # the package's example may lie there too
    once = {(c.name, *sorted(c.data_sha256.items())): c for c in reversed(campaigns)}
    return sorted(once.values(), key=lambda campaign: campaign.name)


def _targets(out: str | None, campaigns: "Sequence[Campaign]") -> list[Path | None]:
    if out is None:
        return [None] * len(campaigns)
    names = [c.name.replace("/", "-").replace("\\", "-").strip(". ") for c in campaigns]
    for name, times in Counter(names).items():
        if times > 1:
            raise InputError(
                f"There are {times} campaigns named {name}, and {out} can hold one {name}.json: "
                "give each a call with an --out of its own."
            )
    return [Path(out, f"{name or 'campaign'}.json") for name in names]


def _cells(found: DiagnosisRecord) -> list[str]:
    gap = found.gap
    shrink = percent(gap.shrink)
    if gap.shrink_ci95:
        shrink += f" ({percents(gap.shrink_ci95)})"
    errors = [
        " → ".join(angle(getattr(getattr(gap, state), kind)) for state in ("before", "after"))
        if found.accepted
        else angle(getattr(gap.before, kind))
        for kind in ("windowed", "free_run")
    ]
    return [
        found.campaign,
        found.verdict or MISSING,
        ", ".join(found.causes) or MISSING,
        shrink,
        *errors,
        angle(found.floor),
        number(found.provenance.wall_s, 2),
    ]


if __name__ == "__main__":
    sys.exit(main())
