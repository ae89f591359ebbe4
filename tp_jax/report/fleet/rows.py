"""A rig of a fleet as a row: where, which, how large, how far, in plain numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

from tp_jax.report.formatting import bounds, finite
from tp_jax.report.inertia import inertia, unit_under
from tp_jax.results.diagnosis import Cause, DiagnosisRecord, Found, Size

SCHEMA = "tp-jax/fleet/1"

FAILED = "failed"
"""The verdict of a rig that could not be diagnosed."""

VERDICTS = ("explained", "unknown", "no_gap", FAILED)
"""In the order of the table: what can be repaired comes first."""

COLUMNS: dict[str, type] = {
    "rig": str,
    "campaign": str,
    "verdict": str,
    "location": str,
    "channel": str,
    "cause": str,
    "probability": float,
    "confused_with": str,
    "other_causes": str,
    "parameter": str,
    "value": float,
    "unit": str,
    "value_low": float,
    "value_high": float,
    "shrink": float,
    "shrink_low": float,
    "shrink_high": float,
    "gap_before": float,
    "gap_after": float,
    "noise_floor": float,
    "wall_s": float,
    "report": str,
    "notices": str,
    "error": str,
}
"""Of a row. Sizes and the interval's ends are in `unit`, gaps and noise in rad. Torques of a rig
whose B1 was not given are per unit of it: "N m/B1"."""


def row(rig: str, found: Found, report: str = "") -> dict[str, Any]:
    """A rig's row; what its diagnosis lacks is None.

    Args:
        rig: its name in the fleet.
        found: its diagnosis, or the dictionary of it.
        report: where its page is, from the fleet's folder.
    """
    diagnosis = DiagnosisRecord.read(found)
    gap, causes = diagnosis.gap, diagnosis.accepted
    first = causes[0] if causes else Cause("")
    # the place of what causes the gap; where nothing is named, of most of the gap
    place = first.location or (diagnosis.where[0].location if diagnosis.where else "")
    channels = [each.channel for each in diagnosis.where if each.location == place]
    # the first of twelve coefficients is no size of a learned curve
    parameters = {} if first.curve is not None else first.parameters
    parameter, size = next(iter(parameters.items()), ("", Size()))
    low, high = bounds(size.ci95) or (None, None)
    shrink = bounds(gap.shrink_ci95) or (None, None)
    return {
        **blank(rig),
        "campaign": diagnosis.campaign or None,
        "verdict": diagnosis.verdict or "unknown",
        "location": place or None,
        "channel": channels[0] or None if channels else None,
        "cause": first.effect or None,
        "probability": first.probability,
        "confused_with": "; ".join(diagnosis.tied_with(first.effect)) or None,
        "other_causes": "; ".join(diagnosis.causes[1:]) or None,
        "parameter": parameter or None,
        "value": finite(size.value),
        "unit": unit_under(inertia(diagnosis), size.unit) or None,
        "value_low": low,
        "value_high": high,
        "shrink": gap.shrink,
        "shrink_low": shrink[0],
        "shrink_high": shrink[1],
        "gap_before": gap.before.windowed,
        "gap_after": gap.after.windowed,
        "noise_floor": diagnosis.floor,
        "wall_s": diagnosis.provenance.wall_s,
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
