"""Two diagnoses side by side: before and after a repair, or two rigs."""

import html
from collections.abc import Iterable, Sequence
from typing import Any

from tp_jax.report import words
from tp_jax.report.formatting import MISSING, angle, bounds, finite, number, percent
from tp_jax.results.diagnosis import Cause, DiagnosisRecord, Size

Row = tuple[str, str, str]


def compared(a: DiagnosisRecord, b: DiagnosisRecord) -> dict[str, Any]:
    """Returns what differs and what does not, for `tp-jax compare --json`.

    Args:
        a, b: two diagnoses.
    """
    effects = _union(_named(a), _named(b))
    parameters = _union(a.parameters, b.parameters)
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
        "parameters": {name: _parameter(name, a, b) for name in parameters},
    }


def rows(a: DiagnosisRecord, b: DiagnosisRecord) -> list[Row]:
    """The same as lines of a table: what, in the first, in the second."""
    both = (a, b)
    lines: list[Row] = [
        _row("campaign", [each.campaign or MISSING for each in both]),
        _row("verdict", [each.verdict or "unknown" for each in both]),
        _row("first cause", [next(iter(_named(each)), MISSING) for each in both]),
        _row("gap gone", [percent(each.gap.shrink) for each in both]),
    ]
    for state, told in (("before", "without effects"), ("after", "with them")):
        for kind, name in (("windowed", "in windows"), ("free_run", "free run")):
            sizes = [getattr(getattr(each.gap, state), kind) for each in both]
            lines.append(_row(f"gap {name}, {told}", [angle(x) for x in sizes]))
    lines.append(_row("noise floor", [angle(each.floor) for each in both]))
    for name in _union(_named(a), _named(b)):
        lines.append(_row(f"cause {name}", [_cause(_named(each).get(name)) for each in both]))
    for name in _union(a.parameters, b.parameters):
        cells = [_value(each.parameters.get(name, Size())) for each in both]
        found = _parameter(name, a, b)
        moved = " *" if found["differs"] else ""
        lines.append(_row(f"{name}{moved}", cells))
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


def _cause(cause: Cause | None) -> str:
    if cause is None:
        return "not found"
    told = [f"{name} {_value(size)}" for name, size in cause.parameters.items()]
    return ", ".join([percent(cause.probability), *told])


def _value(size: Size) -> str:
    value, ends = finite(size.value), bounds(size.ci95)
    if value is None:
        return MISSING
    interval = f" ({number(ends[0])} to {number(ends[1])})" if ends else ""
    return f"{number(value)}{interval}" + (f" {size.unit}" if size.unit not in ("", "1") else "")


def _parameter(name: str, a: DiagnosisRecord, b: DiagnosisRecord) -> dict[str, Any]:
    first, second = (each.parameters.get(name, Size()) for each in (a, b))
    one, other = (bounds(each.ci95) for each in (first, second))
    apart = bool(one and other and (one[1] < other[0] or other[1] < one[0]))
    return {
        "values": [finite(each.value) for each in (first, second)],
        "unit": first.unit or second.unit,
        "ci95": [None if each is None else [*each] for each in (one, other)],
        "differs": apart,
        "says": words.parameter(name),
    }
