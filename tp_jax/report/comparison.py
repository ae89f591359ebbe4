"""Two diagnoses side by side: before and after a repair, or two rigs."""

import html
from collections.abc import Mapping, Sequence
from typing import Any

from tp_jax.report import reading, words
from tp_jax.report.formatting import MISSING, angle, number, percent

Row = tuple[str, str, str]


def compared(a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, Any]:
    """What differs and what does not, for `tp-jax compare --json`.

    Args:
        a, b: contents of two diagnosis.json.
    """
    effects = _union(_named(a), _named(b))
    parameters = _union(reading.table(a, "parameters"), reading.table(b, "parameters"))
    return {
        "schema": "tp-jax/compare/1",
        "campaigns": [reading.text(each, "campaign") for each in (a, b)],
        "verdicts": [reading.verdict(each) for each in (a, b)],
        "gap": {
            f"{state}_{kind}": [reading.value(each, "gap", state, kind) for each in (a, b)]
            for state in ("before", "after")
            for kind in ("windowed", "free_run")
        },
        "noise_floor": [reading.floor(each) for each in (a, b)],
        "causes": {name: [_named(each).get(name) for each in (a, b)] for name in effects},
        "parameters": {name: _parameter(name, a, b) for name in parameters},
    }


def rows(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[Row]:
    """The same as lines of a table: what, in the first, in the second."""
    both = (a, b)
    lines: list[Row] = [
        _row("campaign", [reading.text(each, "campaign") or MISSING for each in both]),
        _row("verdict", [reading.verdict(each) for each in both]),
        _row("first cause", [next(iter(_named(each)), MISSING) for each in both]),
        _row("gap gone", [percent(reading.value(each, "gap", "shrink")) for each in both]),
    ]
    for state, told in (("before", "without effects"), ("after", "with them")):
        for kind, name in (("windowed", "in windows"), ("free_run", "free run")):
            sizes = [reading.value(each, "gap", state, kind) for each in both]
            lines.append(_row(f"gap {name}, {told}", [angle(x) for x in sizes]))
    lines.append(_row("noise floor", [angle(reading.floor(each)) for each in both]))
    for name in _union(_named(a), _named(b)):
        lines.append(_row(f"cause {name}", [_cause(_named(each).get(name)) for each in both]))
    for name in _union(reading.table(a, "parameters"), reading.table(b, "parameters")):
        cells = [_value(reading.table(each, "parameters", name)) for each in both]
        found = _parameter(name, a, b)
        moved = " *" if found["differs"] else ""
        lines.append(_row(f"{name}{moved}", cells))
    return lines


def text(a: Mapping[str, Any], b: Mapping[str, Any]) -> str:
    """The table as plain text; a parameter whose intervals do not meet has a star."""
    table = [("", "A", "B"), *rows(a, b)]
    widths = [max(len(row[i]) for row in table) for i in range(3)]
    lines = ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in table]
    return "\n".join([*lines, "", "* the 95 % intervals do not meet"]) + "\n"


def page(a: Mapping[str, Any], b: Mapping[str, Any]) -> str:
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


def _union(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys([*a, *b]))


def _named(diagnosis: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    return {reading.text(cause, "effect"): cause for cause in reading.causes(diagnosis)}


def _cause(cause: Mapping[str, Any] | None) -> str:
    if cause is None:
        return "not found"
    sizes = reading.table(cause, "parameters")
    told = [f"{name} {_value(size)}" for name, size in sizes.items()]
    return ", ".join([percent(reading.value(cause, "probability")), *told])


def _value(size: Any) -> str:
    value = reading.value(size, "value")
    if value is None:
        return MISSING
    unit = reading.text(size, "unit")
    ends = size.get("ci95")
    interval = f" ({number(ends[0])} to {number(ends[1])})" if _interval(ends) else ""
    return f"{number(value)}{interval}" + (f" {unit}" if unit not in ("", "1") else "")


def _interval(ends: Any) -> bool:
    return isinstance(ends, list | tuple) and len(ends) == 2 and all(e is not None for e in ends)


def _parameter(name: str, a: Mapping[str, Any], b: Mapping[str, Any]) -> dict[str, Any]:
    tables = [reading.table(each, "parameters", name) for each in (a, b)]
    ends: list[Any] = [each for table in tables if _interval(each := table.get("ci95"))]
    known = len(ends) == 2
    apart = known and (ends[0][1] < ends[1][0] or ends[1][1] < ends[0][0])
    return {
        "values": [reading.value(table, "value") for table in tables],
        "unit": reading.text(tables[0], "unit") or reading.text(tables[1], "unit"),
        "ci95": ends,
        "differs": bool(apart),
        "says": words.parameter(name),
    }
