"""A rig of a fleet as a row: where, which, how large, how far, in plain numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

from tp_jax.report import reading
from tp_jax.report.formatting import bounds

SCHEMA = "tp-jax/fleet/1"

FAILED = "failed"
"""The verdict of a rig that could not be diagnosed."""

VERDICTS = ("explained", "unknown", "no_gap", FAILED)
"""In the order of the table: what can be repaired comes first."""

COLUMNS: dict[str, type] = {
    "rig": str, "campaign": str, "verdict": str, "location": str, "channel": str,
    "cause": str, "probability": float, "confused_with": str, "other_causes": str,
    "parameter": str, "value": float, "unit": str, "value_low": float, "value_high": float,
    "shrink": float, "shrink_low": float, "shrink_high": float,
    "gap_before": float, "gap_after": float, "noise_floor": float,
    "wall_s": float, "report": str, "notices": str, "error": str,
}  # fmt: skip
"""Of a row. Sizes and the interval's ends are in `unit`, gaps and noise in rad."""


def row(rig: str, diagnosis: Mapping[str, Any], report: str = "") -> dict[str, Any]:
    """A rig's row; what its diagnosis lacks is None.

    Args:
        rig: its name in the fleet.
        diagnosis: as in diagnosis.json.
        report: where its page is, from the fleet's folder.
    """
    causes = reading.causes(diagnosis)
    first = causes[0] if causes else {}
    places = reading.rows(diagnosis, "where")
    # the place of what causes the gap; where nothing is named, of most of the gap
    effect = reading.text(first, "effect")
    place = reading.text(first, "location") or (
        reading.text(places[0], "location") if places else ""
    )
    channels = [reading.text(each, "channel") for each in places
                if reading.text(each, "location") == place]  # fmt: skip
    sizes = reading.table(first, "parameters")
    parameter = next(iter(sizes), "")
    size = reading.table(sizes, parameter)
    low, high = bounds(size.get("ci95")) or (None, None)
    shrink = bounds(reading.table(diagnosis, "gap").get("shrink_ci95")) or (None, None)
    return {
        **blank(rig),
        "campaign": reading.text(diagnosis, "campaign") or None,
        "verdict": reading.verdict(diagnosis),
        "location": place or None,
        "channel": channels[0] or None if channels else None,
        "cause": effect or None,
        "probability": reading.value(first, "probability"),
        "confused_with": "; ".join(reading.tied_with(diagnosis, effect)) or None,
        "other_causes": "; ".join(reading.text(each, "effect") for each in causes[1:]) or None,
        "parameter": parameter or None,
        "value": reading.value(size, "value"),
        "unit": reading.text(size, "unit") or None,
        "value_low": low,
        "value_high": high,
        "shrink": reading.value(diagnosis, "gap", "shrink"),
        "shrink_low": shrink[0],
        "shrink_high": shrink[1],
        "gap_before": reading.value(diagnosis, "gap", "before", "windowed"),
        "gap_after": reading.value(diagnosis, "gap", "after", "windowed"),
        "noise_floor": reading.floor(diagnosis),
        "wall_s": reading.value(diagnosis, "provenance", "wall_s"),
        "report": report or None,
    }


def failed(rig: str, sentence: str) -> dict[str, Any]:
    """The row of a rig that could not be diagnosed, with the sentence that says why."""
    return {**blank(rig), "verdict": FAILED, "error": sentence}


def blank(rig: str) -> dict[str, Any]:
    """A row that says nothing but the rig's name."""
    return {**dict.fromkeys(COLUMNS), "rig": rig}


def in_order(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Rows by verdict, cause and shrink; those that failed come last."""

    def key(one: Mapping[str, Any]) -> tuple:
        shrink = one["shrink"] if one["shrink"] is not None else -1.0
        return VERDICTS.index(one["verdict"]), one["cause"] or "~", -shrink, one["rig"]

    return [dict(one) for one in sorted(rows, key=key)]


def counts(rows: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Rigs of each verdict, all verdicts named."""
    return {name: sum(one["verdict"] == name for one in rows) for name in VERDICTS}


def by_cause(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Rigs by their first cause, the most frequent one first."""
    causes = sorted({one["cause"] for one in rows if one["cause"]})
    groups = {cause: [one for one in rows if one["cause"] == cause] for cause in causes}
    return dict(sorted(groups.items(), key=lambda item: -len(item[1])))
