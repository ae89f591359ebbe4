"""The verdict as plain text for a terminal: at most 25 lines."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from tp_jax.report import reading, verdict
from tp_jax.report.formatting import angles, percent, probability

WIDTH = 100
MOST_LINES = 25
_MOST_CAUSES = 3
_MOST_CANDIDATES = 5
_MOST_GROUPS = 2


def summary(diagnosis: Mapping[str, Any]) -> str:
    """The verdict, the numbers behind it and what to do next.

    Args:
        diagnosis: as in diagnosis.json; whatever is missing is left out.

    Returns:
        at most 25 lines without a line feed at the end, no colours.
    """
    lines = [*_verdict(diagnosis), *_gap(diagnosis), *_causes(diagnosis)]
    rivals, last = _candidates(diagnosis), _last(diagnosis)
    # Long sentences may fill the space. Then an empty line gives way first, next the causes among
    # the candidates, which have a table of their own, and at last the least of the candidates.
    space = MOST_LINES - len(lines)
    if len(rivals) + len(last) > space:
        last = last[1:]
    if len(rivals) + len(last) > space:
        rivals = _candidates(diagnosis, without=reading.causes(diagnosis))
    return "\n".join([*[*lines, *rivals][: MOST_LINES - len(last)], *last])


def _verdict(diagnosis: Mapping[str, Any]) -> list[str]:
    said = verdict.sentences(diagnosis)
    name = reading.text(diagnosis, "campaign")
    lines = [f"{name}: {said.heading}" if name else said.heading]
    what = f"{said.what} {said.tied}".strip()
    for sentence in (said.where, what, f"{said.how_far} {said.agreement}".strip()):
        lines += textwrap.wrap(sentence, WIDTH)
    lines += textwrap.wrap(f"What to do: {said.remedy}" if said.remedy else "", WIDTH)
    return lines


def _gap(diagnosis: Mapping[str, Any]) -> list[str]:
    gap, floor = reading.table(diagnosis, "gap"), reading.floor(diagnosis)
    states = reading.states(diagnosis)
    body = []
    for key, name in (("windowed", "in windows"), ("free_run", "free run")):
        sizes = [reading.value(gap, state, key) for state in states]
        if any(size is not None for size in sizes):
            body.append([name, *angles([*sizes, floor])])
    return _table(["held-out error (rms)", *states, "noise floor"], body)


def _causes(diagnosis: Mapping[str, Any]) -> list[str]:
    body = []
    causes = reading.causes(diagnosis)
    for cause in causes[:_MOST_CAUSES]:
        sizes = [size.replace("95 % interval ", "95 %: ") for size in verdict.sizes(cause)]
        more = f", and {len(sizes) - 2} more" if len(sizes) > 2 else ""
        body.append(
            [
                reading.text(cause, "effect"),
                probability(cause.get("probability")),
                percent(cause.get("shrink")),
                ", ".join(sizes[:2]) + more,
            ]
        )
    lines = _table(["cause", "probability", "shrink", "size"], body)
    if len(causes) > _MOST_CAUSES:
        lines.append(f"  and {len(causes) - _MOST_CAUSES} more")
    return lines


def _candidates(
    diagnosis: Mapping[str, Any], without: Sequence[Mapping[str, Any]] = ()
) -> list[str]:
    found = [row for row in reading.candidates(diagnosis) if reading.judged(row)]
    named = {reading.text(cause, "effect") for cause in without}
    body = [
        [
            reading.text(row, "effect"),
            percent(row.get("predicted_shrink")),
            percent(row.get("realised_shrink")),
            probability(row.get("probability")),
            reading.text(row, "note"),
        ]
        for row in found[:_MOST_CANDIDATES]
        if reading.text(row, "effect") not in named
    ]
    head = ["candidate", "predicted shrink", "realised shrink", "probability", "why it is no cause"]
    noted = any(row[-1] for row in body)
    return _table(head, body) if noted else _table(head[:-1], [row[:-1] for row in body])


def _last(diagnosis: Mapping[str, Any]) -> list[str]:
    lines = []
    causes = {reading.text(cause, "effect") for cause in reading.causes(diagnosis)}
    # what a cause is not told from stands beside it
    groups = [group for group in reading.groups(diagnosis) if not causes & set(group)]
    for group in groups[:_MOST_GROUPS]:
        lines.append(_line("Not told apart: " + ", ".join(group)))
    if len(groups) > _MOST_GROUPS:
        more = len(groups) - _MOST_GROUPS
        lines[-1] = _line(f"{lines[-1]}; and {more} more group{'s' if more > 1 else ''}")
    following = verdict.next_experiment(diagnosis)
    if following:
        lines += textwrap.wrap(f"Next: {following}", WIDTH)[:2]
    return ["", *lines] if lines else []


def _line(text: str) -> str:
    return textwrap.shorten(text, WIDTH, placeholder=" ...")


def _table(head: Sequence[str], body: Sequence[Sequence[str]]) -> list[str]:
    """Columns as wide as they need to be, an empty line before; nothing without rows."""
    if not body:
        return []
    widths = [max(len(cell) for cell in column) for column in zip(head, *body, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in (head, *body)
    ]
    return ["", *(_cut(line) for line in lines)]


def _cut(line: str) -> str:
    return line if len(line) <= WIDTH + 24 else line[: WIDTH + 20].rstrip() + " ..."
