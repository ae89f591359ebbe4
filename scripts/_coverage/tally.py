"""Shares of intervals that held the truth."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import stats

from scripts._coverage.rig import PROFILED

TARGET = (0.93, 0.97)
ORDER = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")


def tally(results: Mapping[int, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Parameter -> how many intervals, how many held the truth, the share with its own 95 %
    interval (Wilson), whether that interval meets the target, median half width relative to the
    truth, how many are open at an end."""
    out = {}
    for name in ORDER:
        rows = [r["parameters"][name] for r in results.values() if name in r["parameters"]]
        if not rows:
            continue
        out[name] = _share(rows) | {"by": "profile" if name in PROFILED else "standard error"}
        wald = [
            row["wald"] | {"open": None in row["wald"]["ci95"]} for row in rows if "wald" in row
        ]
        if wald:
            truths = [row["truth"] for row in rows if "wald" in row]
            rows = [w | {"truth": t} for w, t in zip(wald, truths, strict=True)]
            out[name]["by_standard_error"] = _share(rows)
    return out


def _share(rows: list[Mapping[str, Any]]) -> dict[str, Any]:
    held, of = sum(row["covered"] for row in rows), len(rows)
    low, high = stats.binomtest(held, of).proportion_ci(method="wilson")
    closed = [row for row in rows if None not in row["ci95"] and row["truth"]]
    half = [0.5 * (r["ci95"][1] - r["ci95"][0]) / r["truth"] for r in closed]
    return {
        "covered": int(held),
        "of": of,
        "share": held / of,
        "ci95": [float(low), float(high)],
        "within_target": bool(TARGET[0] <= held / of <= TARGET[1]),
        "may_be_within_target": bool(low <= TARGET[1] and high >= TARGET[0]),
        "half_width": float(np.median(half)) if half else None,
        "open": sum(row["open"] for row in rows),
    }


def lines(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A table as plain text."""
    out = [f"{'':5}{'held':>11}{'share':>8}  {'95 % interval':18}{'half width':>11}{'open':>6}  by"]
    for name, row in found.items():
        low, high = row["ci95"]
        width = "-" if row["half_width"] is None else f"{100.0 * row['half_width']:.2g} %"
        count, span = f"{row['covered']}/{row['of']}", f"{low:.3f} to {high:.3f}"
        out.append(
            f"{name:5}{count:>11}{row['share']:8.3f}  {span:18}{width:>11}{row['open']:>6}  "
            f"{row['by']}"
        )
    return out
