"""The verdict as plain text for a terminal: at most 25 lines."""

import textwrap
from collections.abc import Collection, Sequence

from tp_jax.report import verdict
from tp_jax.report.formatting import MISSING, angles, percent, probability
from tp_jax.results.diagnosis import DiagnosisRecord, Found

WIDTH = 100
MOST_LINES = 25
_MOST_CAUSES = 3
_MOST_CANDIDATES = 5
_MOST_GROUPS = 2


def summary(found: Found) -> str:
    """The verdict, the numbers behind it and what to do next.

    Args:
        found: a diagnosis, or the dictionary of it; whatever is missing is left out.

    Returns:
        at most 25 lines without a line feed at the end, no colours.
    """
    diagnosis = DiagnosisRecord.read(found)
    tables = [*_gap(diagnosis), *_causes(diagnosis)]
    lines = [*_verdict(diagnosis), *tables]
    rivals, last = _candidates(diagnosis), _last(diagnosis)
    # Long sentences may fill the space. Then an empty line gives way first, next the causes among
    # the candidates, which have a table of their own, then the least of the candidates, and at last
    # what to do and what is not told apart, which the report has too: the sizes of causes stay.
    if len(lines) + len(last) > MOST_LINES:
        lines = [*_verdict(diagnosis, remedy=False), *tables]
    if len(lines) + len(last) > MOST_LINES:
        last = _last(diagnosis, groups=False)
    space = MOST_LINES - len(lines)
    if len(rivals) + len(last) > space:
        last = last[1:]
    if len(rivals) + len(last) > space:
        rivals = _candidates(diagnosis, without=diagnosis.causes)
    return "\n".join([*[*lines, *rivals][: MOST_LINES - len(last)], *last])


def _verdict(diagnosis: DiagnosisRecord, remedy: bool = True) -> list[str]:
    said = verdict.sentences(diagnosis)
    name = f"{diagnosis.campaign}: " if diagnosis.campaign else ""
    lines = [name + said.heading]
    what = f"{said.what} {said.tied}".strip()
    for sentence in (said.where, what, f"{said.how_far} {said.agreement}".strip()):
        lines += textwrap.wrap(sentence, WIDTH)
    lines += textwrap.wrap(f"What to do: {said.remedy}" if remedy and said.remedy else "", WIDTH)
    return lines


def _gap(diagnosis: DiagnosisRecord) -> list[str]:
    body = []
    for kind, name in (("windowed", "in windows"), ("free_run", "free run")):
        sizes = [getattr(getattr(diagnosis.gap, state), kind) for state in diagnosis.states]
        if any(size is not None for size in sizes):
            body.append([name, *angles([*sizes, diagnosis.floor])])
    return _table(["held-out error (rms)", *diagnosis.states, "noise floor"], body)


def _causes(diagnosis: DiagnosisRecord) -> list[str]:
    body = []
    for cause in diagnosis.accepted[:_MOST_CAUSES]:
        sizes = verdict.sizes(cause, "95 %: ")
        more = f", and {len(sizes) - 2} more" if len(sizes) > 2 else ""
        numbers = [probability(cause.probability), percent(cause.shrink)]
        body.append([cause.effect, *numbers, ", ".join(sizes[:2]) + more])
    lines = _table(["cause", "probability", "shrink", "size"], body)
    if len(diagnosis.accepted) > _MOST_CAUSES:
        lines.append(f"  and {len(diagnosis.accepted) - _MOST_CAUSES} more")
    return lines


def _candidates(diagnosis: DiagnosisRecord, without: Collection[str] = ()) -> list[str]:
    found = [row for row in diagnosis.applicable if row.judged]
    body = [
        [
            row.effect,
            percent(row.predicted_shrink),
            percent(row.realised_shrink),
            probability(row.probability),
            row.note or MISSING,
        ]
        for row in found[:_MOST_CANDIDATES]
        if row.effect not in without
    ]
    # once a cause is taken, probabilities are of all rounds together
    name = "candidate, any round" if diagnosis.accepted else "candidate"
    head = [name, "predicted shrink", "realised shrink", "probability", "why it is no cause"]
    said = [i for i in range(len(head)) if i == 0 or any(row[i] != MISSING for row in body)]
    return _table([head[i] for i in said], [[row[i] for i in said] for row in body])


def _last(diagnosis: DiagnosisRecord, groups: bool = True) -> list[str]:
    lines = []
    # what a cause is not told from stands beside it
    found = [group for group in diagnosis.groups if not {*diagnosis.causes} & {*group}]
    found = found if groups else []
    for group in found[:_MOST_GROUPS]:
        lines.append(_line("These recordings cannot tell apart: " + ", ".join(group)))
    if len(found) > _MOST_GROUPS:
        more = len(found) - _MOST_GROUPS
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
