"""Two diagnoses side by side: before and after a repair, or two rigs.

Without the column's inertia B1 all torques of a diagnosis are in units of it. Where one of two
has none, torques and inertias of both are compared per B1.
"""

import dataclasses
import html
from collections.abc import Iterable, Sequence
from typing import Any

from tp_jax.model.inertia_units import per_inertia, scales
from tp_jax.report import words
from tp_jax.report.formatting import (
    MISSING,
    angle,
    bounds,
    finite,
    number,
    percent,
    probability,
    size,
)
from tp_jax.report.inertia import given, inertia
from tp_jax.report.verdict import sizes
from tp_jax.results.diagnosis import Cause, DiagnosisRecord, Size

Row = tuple[str, str, str]


def compared(a: DiagnosisRecord, b: DiagnosisRecord) -> dict[str, Any]:
    """Returns what differs and what does not, for `tp-jax compare --json`.

    Values and intervals are those of the diagnoses; "differs" is per B1 where one of them has none.

    Args:
        a, b: two diagnoses.
    """
    effects = _union(_named(a), _named(b))
    parameters = _union(a.parameters, b.parameters)
    inertias = [inertia(each) for each in (a, b)]
    return {
        "schema": "tp-jax/compare/1",
        "campaigns": [each.campaign for each in (a, b)],
        "verdicts": [each.verdict or "unknown" for each in (a, b)],
        "gap": {
            f"{state}_{kind}": [getattr(getattr(each.gap, state), kind) for each in (a, b)]
            for state in ("before", "after")
            for kind in ("windowed", "free_run")
        },
        "noise_floor": [each.floor for each in (a, b)],
        "causes": {name: [_cause_of(each, name) for each in (a, b)] for name in effects},
        "B1": [None if each == 1.0 else each for each in inertias],
        "parameters": {
            name: _parameter(name, [each.parameters.get(name, Size()) for each in (a, b)], inertias)
            for name in parameters
        },
    }


def rows(a: DiagnosisRecord, b: DiagnosisRecord) -> list[Row]:
    """The same as lines of a table: what, in the first, in the second."""
    both = (a, b)
    lines: list[Row] = [
        _row("campaign", [each.campaign or MISSING for each in both]),
        _row("verdict", [each.verdict or MISSING for each in both]),
        _row("first cause", [next(iter(_named(each)), MISSING) for each in both]),
        _row("gap gone", [percent(each.gap.shrink) for each in both]),
    ]
    for state, told in (("before", "without effects"), ("after", "with them")):
        for kind, name in (("windowed", "in windows"), ("free_run", "free run")):
            errors = [getattr(getattr(each.gap, state), kind) for each in both]
            lines.append(_row(f"gap {name}, {told}", [angle(x) for x in errors]))
    lines.append(_row("noise floor", [angle(each.floor) for each in both]))
    inertias = [inertia(each) for each in both]
    shared = _per_inertia(inertias)
    for name in _union(_named(a), _named(b)):
        causes = [_named(each).get(name) for each in both]
        told = [_cause(c, B1 if shared else None) for c, B1 in zip(causes, inertias, strict=True)]
        lines.append(_row(f"cause {name}", told))
    told = [MISSING if B1 is None else _inertia_told(B1) for B1 in inertias]
    lines.append(_row("B1, as it was given", told))
    for name in _union(a.parameters, b.parameters):
        each = [one.parameters.get(name, Size()) for one in both]
        moved = " *" if _parameter(name, each, inertias)["differs"] else ""
        if shared:
            each = [_scaled(one, B1) for one, B1 in zip(each, inertias, strict=True)]
        lines.append(
            _row(f"{name}{moved}", [size(one.value, one.unit, one.ci95, "") for one in each])
        )
    return lines


def text(a: DiagnosisRecord, b: DiagnosisRecord) -> str:
    """The table as plain text; a parameter whose intervals do not meet has a star."""
    table = [("", "A", "B"), *rows(a, b)]
    widths = [max(len(row[i]) for row in table) for i in range(3)]
    lines = ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in table]
    return "\n".join([*lines, "", "* the 95 % intervals do not meet"]) + "\n"


def page(a: DiagnosisRecord, b: DiagnosisRecord) -> str:
    """The table as a page of its own, that loads nothing."""
    cells = "".join(
        "<tr><th scope=row>" + "<td>".join(html.escape(cell) for cell in row) for row in rows(a, b)
    )
    return (
        "<!DOCTYPE html><html lang=en><meta charset=utf-8>"
        '<meta name=viewport content="width=device-width, initial-scale=1">'
        "<title>Two diagnoses</title><style>:root{color-scheme:light dark}"
        "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
        "div{overflow-x:auto}table{border-collapse:collapse}"
        "th,td{text-align:left;padding:.25rem 1rem .25rem 0;border-bottom:1px solid #8c959f55}"
        "th{font-weight:normal}</style><main><h1>Two diagnoses</h1><div tabindex=0>"
        f"<table><thead><tr><td><th scope=col>A<th scope=col>B<tbody>{cells}</table></div>"
        "<p>* the 95 % intervals do not meet</p></main></html>\n"
    )


def _row(name: str, cells: Sequence[str]) -> Row:
    return name, cells[0], cells[1]


def _union(a: Iterable[str], b: Iterable[str]) -> list[str]:
    return list(dict.fromkeys([*a, *b]))


def _named(diagnosis: DiagnosisRecord) -> dict[str, Cause]:
    return {cause.effect: cause for cause in diagnosis.accepted}


def _cause_of(diagnosis: DiagnosisRecord, name: str) -> dict[str, Any] | None:
    cause = _named(diagnosis).get(name)
    return None if cause is None else cause.to_dict()


def _cause(cause: Cause | None, B1: float | None) -> str:
    """Probability and sizes of a cause; B1: its diagnosis' own, where it is compared per B1."""
    if cause is None:
        return "not found"
    if B1 is not None:
        parameters = {name: _scaled(each, B1) for name, each in cause.parameters.items()}
        cause = dataclasses.replace(cause, parameters=parameters)
        curve = cause.curve
        if curve is not None and scales(curve.y_unit):
            y = tuple(each / B1 for each in curve.y)
            curve = dataclasses.replace(curve, y=y, y_unit=per_inertia(curve.y_unit))
            cause = dataclasses.replace(cause, curve=curve)
    return ", ".join([probability(cause.probability), *sizes(cause, "")])


def _inertia_told(B1: float) -> str:
    return f"{number(B1, 7)} kg m^2" if given(B1) else "not given, torques are per B1"


def _per_inertia(inertias: Sequence[float | None]) -> bool:
    """True where one of two diagnoses was given no B1, and the other was."""
    told = [given(B1) for B1 in inertias if B1 is not None]
    return len(told) == 2 and told[0] != told[1]


def _scaled(of: Size, B1: float | None) -> Size:
    """A torque or an inertia per B1; anything else as it is."""
    value, ends = finite(of.value), bounds(of.ci95)
    if B1 is None or value is None or not scales(of.unit):
        return of
    ci95 = None if ends is None else (ends[0] / B1, ends[1] / B1)
    return dataclasses.replace(of, value=value / B1, ci95=ci95, unit=per_inertia(of.unit))


def _parameter(name: str, of: Sequence[Size], inertias: Sequence[float | None]) -> dict[str, Any]:
    first, second = of
    one, other = (bounds(each.ci95) for each in of)
    ends = [one, other]
    if _per_inertia(inertias):
        ends = [bounds(_scaled(s, B1).ci95) for s, B1 in zip(of, inertias, strict=True)]
    apart = bool(ends[0] and ends[1] and (ends[0][1] < ends[1][0] or ends[1][1] < ends[0][0]))
    return {
        "values": [finite(each.value) for each in (first, second)],
        "unit": first.unit or second.unit,
        "ci95": [None if each is None else [*each] for each in (one, other)],
        "differs": apart,
        "says": words.parameter(name),
    }
