"""A fleet for a terminal: a line for each rig, and what could not be diagnosed."""

from collections.abc import Mapping, Sequence
from typing import Any

from tp_jax.report.fleet.rows import FAILED, VERDICTS, counts
from tp_jax.report.fleet.shared import lines as of_shared
from tp_jax.report.formatting import MISSING, percent

NAMES = {"explained": "explained", "unknown": "unknown", "no_gap": "no gap", FAILED: "failed"}


def summary(rows: Sequence[Mapping[str, Any]], shared: Mapping[str, Any] | None = None) -> str:
    """Counts rigs by verdict, with a table, and a sentence for each that failed.

    Args:
        rows: as `rows.row` and `rows.failed` make them.
        shared: what the rigs share, as fleet.json has it; None where nobody asked.
    """
    known = counts(rows)
    said = ", ".join(f"{known[name]} {NAMES[name]}" for name in VERDICTS if known[name])
    rigs = "rig" if len(rows) == 1 else "rigs"
    head = ("rig", "verdict", "cause", "place", "shrink")
    table = [head, *(_cells(row) for row in rows if row["verdict"] != FAILED)]
    widths = [max(len(line[i]) for line in table) for i in range(len(head))]
    lines = ["  ".join(map(str.ljust, line, widths)).rstrip() for line in table]
    faults = [f"{row['rig']}: {row['error']}" for row in rows if row["verdict"] == FAILED]
    common = [] if shared is None else ["", *of_shared(shared)]
    told = [f"{len(rows)} {rigs}: {said}", *(lines if len(table) > 1 else []), *faults, *common]
    return "\n".join(told)


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        row["rig"],
        NAMES[row["verdict"]],
        row["cause"] or MISSING,
        row["location"] or MISSING,
        percent(row["shrink"]),
    )
