"""Identifies campaigns by every method: where each ended, evaluations, and CPU time.

Each method runs in a process of its own, as from the command line, twice: the first run compiles
and does not count.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scripts._carried_out import carried_out
from scripts._markdown import circumstances, row
from tp_jax.cli.arguments import Parser
from tp_jax.cli.diagnose import EXAMPLE
from tp_jax.cli.identify import METHODS

WINDOWS = tuple(m for m in METHODS if m != "nelder-mead")  # which has another objective
HEAD = ("campaign", "method", "χ² above the best", "χ² by dof", "ended", "evaluations", "CPU s")


def main(argv: Sequence[str] | None = None) -> int:
    parser = Parser(
        prog="scripts/methods",
        description="Identifies campaigns by every method that fits windows and prints a table.",
    )
    parser.add_argument(
        "campaigns",
        metavar="CAMPAIGN",
        nargs="*",
        default=[str(EXAMPLE)],
        help="folders with a campaign.toml; default: the example that comes with the package",
    )
    parser.add_argument("--methods", nargs="+", choices=WINDOWS, default=WINDOWS)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return carried_out("methods", _table, parser.parse_args(argv), resumes=False)


def _table(args: Any) -> int:
    print(row(HEAD))
    print(row("---" for _ in HEAD), flush=True)
    for folder in args.campaigns:
        ended = {m: _identified(str(Path(folder).resolve()), m) for m in args.methods}
        lowest = min(result["objective"] for result, _ in ended.values())
        usual = ended.get(WINDOWS[0], (None, None))[1]
        for method, (result, seconds) in ended.items():
            start, times = result["starts"][0], f" ({seconds / usual:.1f}×)" if usual else ""
            print(
                row(
                    (
                        result["campaign"],
                        f"`{method}`",
                        f"{result['objective'] - lowest:,.1f}",
                        f"{result['chi2_dof']:.4g}",
                        "yes" if start["converged"] else "at its limit",
                        start["evaluations"],
                        f"{seconds:.0f}{times}",
                    )
                ),
                flush=True,
            )
    print(f"\n{circumstances(0)} In brackets: times the CPU of `{WINDOWS[0]}`.")
    return 0


def _identified(folder: str, method: str) -> tuple[dict[str, Any], float]:
    """The result of the second run, and its CPU seconds."""
    with tempfile.TemporaryDirectory() as place:
        seconds = 0.0
        for name in ("first.json", "second.json"):
            before = _spent()
            subprocess.run(
                [
                    sys.executable,
                    "-m",
                    "tp_jax",
                    "--quiet",
                    "identify",
                    folder,
                    "--method",
                    method,
                    "--json",
                    name,
                ],
                cwd=place,
                check=True,
                env=os.environ,
                stdout=subprocess.DEVNULL,
            )
            seconds = _spent() - before
        return json.loads(Path(place, "second.json").read_text()), seconds


def _spent() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    sys.exit(main())
