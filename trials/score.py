"""The score of a trial: the key is opened, and every diagnosis held against it."""

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.errors import InputError
from trials.judge import judge, said
from trials.measures import mean, reliability, share
from trials.seal import open_key, read_diagnosis

SCHEMA = "tp-jax/blind/1"
BANDS = ((0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 5.0), (5.0, 10.0), (10.0, np.inf))
ENOUGH = 3.0  # times the minimum detectable size: from here on most should be right
NEAR = 0.1  # a shrink so near the best possible is right
QUESTIONS = (
    "top1",
    "top3",
    "location",
    "false_alarm",
    "unknown",
    "both_named",
    "top1_alone",
    "channel",
    "channel_outside",
    "one_named",
    "explained",
    "undetectable",
    "cousin",
    "cousin_location",
    "harm_windowed",
    "harm_free_run",
    "harm",
)
FOUND = ("top1", "unknown", "cousin")  # what is right of one hidden effect

Progress = Callable[[str, float | None], None]
#: root, part of the key, diagnosis -> {"shrink": .., "best": ..}; see `sealed_runs`.
Shrinks = Callable[[Path, Mapping[str, Any], Mapping[str, Any]], Mapping[str, Any]]
#: root, part of the key, diagnosis -> {"windowed": .., "free_run": ..}; see `harm`.
Harms = Callable[[Path, Mapping[str, Any], Mapping[str, Any]], Mapping[str, Any]]


def score(
    directory: str | os.PathLike[str],
    *,
    shrinks: Shrinks | None = None,
    harms: Harms | None = None,
    first: int | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Opens the key and scores all diagnoses.

    Args:
        directory: a trial that `make` made and of which every case is diagnosed.
        shrinks: how much of the removable gap a diagnosis takes from runs that were never given,
            and the most that could be; `sealed_runs.measured` computes both. If None, the
            diagnosis' own shrink on the recording it held out itself stands for the one, and 1
            for the other.
        harms: whether a diagnosis with causes predicts the sealed runs worse than without them,
            windowed and in free run; `harm.measured_harm` computes it. If None, nobody knows.
        first: cases that count, in order, where not all could be diagnosed; see `seal.open_key`.
        progress: called with a stage's name and the part of it that is done.

    Returns:
        Plain data for JSON, schema tp-jax/blind/1. Measures have "value", "n" and "ci95", shares
        Wilson's. Those on top are over all sizes; "from_3" has the same for effects of three times
        their minimum detectable size or more, "bands" between two multiples of it.

    Raises:
        InputError: a diagnosis is missing or is none, or the key is not the one committed to.
    """
    root = Path(directory)
    key = open_key(root, first)
    entries = key["cases"]
    rows = []
    for i, entry in enumerate(entries):
        if progress is not None:
            progress("scoring cases", i / len(entries))
        diagnosis = read_diagnosis(root, entry)
        row = judge(entry, diagnosis)
        if entry["kind"] in ("one", "two"):
            row["shrink"] = dict((shrinks or own_held_out)(root, entry, diagnosis))
        if harms is not None and row["causes"]:
            row |= _harm(harms(root, entry, diagnosis))
        rows.append(row)
    on = "the run it held out" if shrinks is None else "sealed runs"
    return _scored(rows, [key["sha256"]], on, key.get("rigs", "clean"))


def _harm(found: Mapping[str, Any]) -> dict[str, bool | None]:
    """Harm of a row: windowed, in free run, and in either."""
    both = [found.get("windowed"), found.get("free_run")]
    known = [x for x in both if x is not None]
    return {
        "harm_windowed": both[0],
        "harm_free_run": both[1],
        "harm": any(known) if known else None,
    }


def pool(scores: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One score of several trials.

    Args:
        scores: of trials of one and the same program.

    Raises:
        InputError: one of them is no score, one trial is in two of them, or their rigs or
            shrinks are not of the same kind.
    """
    for one in scores:
        if one.get("schema") != SCHEMA or not one.get("keys"):
            raise InputError("What is to be pooled must be scores of blind trials (score.json).")
    keys = [key for one in scores for key in one["keys"]]
    if len(set(keys)) < len(keys):
        raise InputError("A trial counts once, but one of those to be pooled is there twice.")
    kinds = {one["shrink_error"]["on"] for one in scores}
    if len(kinds) > 1:
        raise InputError("Shrinks on sealed runs and on held-out ones cannot be pooled.")
    rigs = {one.get("rigs", "clean") for one in scores}
    if len(rigs) > 1:
        raise InputError("Trials on clean and on rough rigs cannot be pooled.")
    return _scored([row for one in scores for row in one["rows"]], keys, kinds.pop(), rigs.pop())


def _scored(
    rows: Sequence[Mapping[str, Any]], keys: list[str], on: str, rigs: str
) -> dict[str, Any]:
    scored = {"schema": SCHEMA, "keys": keys, "rigs": rigs, "cases": len(rows), **summary(rows)}
    scored["shrink_error"]["on"] = on
    return scored


def own_held_out(
    root: Path,  # noqa: ARG001
    entry: Mapping[str, Any],  # noqa: ARG001
    diagnosis: Mapping[str, Any],
) -> dict[str, float | None]:
    """The shrink that a diagnosis gives itself, on the recording it held out."""
    return {"shrink": (diagnosis.get("gap") or {}).get("shrink"), "best": 1.0}


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """All measures of judged cases."""
    first = [row["first"] for row in rows if row.get("first")]
    return {
        **measures(rows),
        "reliability": reliability([(f["probability"], f["right"]) for f in first]),
        "confusion": confusion(rows),
        "kinds": dict(Counter(row["kind"] for row in rows)),
        "from_3": measures([row for row in rows if (row["multiple"] or 0.0) >= ENOUGH]),
        "bands": [
            {
                "from": low,
                "to": high if np.isfinite(high) else None,
                **measures([row for row in rows if _within(row, low, high)]),
            }
            for low, high in BANDS
        ],
        "effects": by_effect(rows),
        "rows": list(rows),
    }


def measures(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Every share that the cases answer, the error of shrink, and the coverage of intervals."""
    out: dict[str, Any] = {}
    for question in QUESTIONS:
        asked = rows
        if question == "channel_outside":
            asked = [row for row in rows if row["kind"] == "outside"]
        name = question.removesuffix("_outside")
        out[question] = share([row[name] for row in asked if row.get(name) is not None])
    # a model that does worse than the baseline takes nothing away
    errors = [
        abs(_clipped(row["shrink"]["best"]) - _clipped(row["shrink"]["shrink"]))
        for row in rows
        if row.get("shrink")
        and row["shrink"]["shrink"] is not None
        and row["shrink"]["best"] is not None
    ]
    out["shrink_error"] = mean(errors)
    out["shrink_near"] = share([error <= NEAR for error in errors])
    for what in ("amplitudes", "parameters"):
        held = [yes for row in rows if row["coverage"] for yes in row["coverage"][what]]
        out[f"coverage_{what}"] = share(held)
    return out


def confusion(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Counts what was hidden -> what was said first -> how often; ties not counted as one.

    Two effects at once are in it as "one + other".
    """
    table: dict[str, Counter[str]] = {}
    for row in rows:
        hidden = " + ".join(sorted(row["effects"])) or "none"
        answer = said(row)
        if row["kind"] == "two" and row["causes"]:
            answer = " + ".join(sorted(row["causes"]))
        table.setdefault(hidden, Counter())[answer] += 1
    return {hidden: dict(table[hidden].most_common()) for hidden in sorted(table)}


def by_effect(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Effect, alone in its rig -> how well it is found; ids of the catalogue and outside it."""
    single = [row for row in rows if row["kind"] in ("one", "outside", "cousin")]
    out = {}
    for id in sorted({row["effects"][0] for row in single}):
        mine = [row for row in single if row["effects"][0] == id]
        sizes = [row["multiple"] for row in mine if row["multiple"] is not None]
        wrong = Counter(said(row) for row in mine if not any(row.get(n) for n in FOUND))
        out[id] = {
            "kind": mine[0]["kind"],
            "multiple": float(np.median(sizes)) if sizes else None,
            "top1": share([row["top1"] for row in mine if row["top1"] is not None]),
            "top3": share([row["top3"] for row in mine if row["top3"] is not None]),
            "location": share([row["location"] for row in mine if row["location"] is not None]),
            "unknown": share([row["unknown"] for row in mine if row["unknown"] is not None]),
            "cousin": share([row["cousin"] for row in mine if row.get("cousin") is not None]),
            "channel": share([row["channel"] for row in mine]),
            "instead": dict(wrong.most_common(3)),
        }
    return out


def _within(row: Mapping[str, Any], low: float, high: float) -> bool:
    return row["multiple"] is not None and low <= row["multiple"] < high


def _clipped(shrink: float) -> float:
    return min(max(shrink, 0.0), 1.0)
