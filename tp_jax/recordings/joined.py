"""Rows of names between rows of numbers: two logs in one file."""

import re

import numpy as np

from tp_jax.recordings.cells import number, split_title
from tp_jax.recordings.clock_times import is_date_or_clock, seconds_since_first
from tp_jax.recordings.faults import CampaignError, in_rows
from tp_jax.recordings.layout import Layout, is_number
from tp_jax.recordings.lines import Lines
from tp_jax.recordings.sources import NAMES
from tp_jax.recordings.units import parted

_WORD = re.compile(r"[A-DF-SU-YÀ-ža-df-yΑ-ω°µ%\"]")
"""Characters that a row of names has, and numbers and dates have not."""

_NAME = re.compile(r"[^\W\d][\w .-]*(?:[\[(/].*)?")
"""A name of a column, with or without its unit."""


def check_joined(lines: Lines, layout: Layout, t: int | None) -> None:
    """Faults rows of names between rows of numbers.

    Args:
        lines: of the file.
        layout: of the file.
        t: index of the column of times; None where it is not known.

    Raises:
        CampaignError: at the first of them, with what to do.
    """
    groups = _groups(lines, layout)
    named = [group for group in groups if any(_names(lines, layout, i) for i in group)]
    if not named:
        _check_text(lines, layout, t, groups)
        return
    at = [lines.numbers[i] for group in named for i in group]
    again = all(_same(lines, layout, group) for group in named)
    on = t is not None and all(_goes_on(lines, layout, t, group) for group in named)
    split = "split the file before this line, a file for each run"
    if again and on:
        wrong = f"the columns' names stand here again{in_rows(at)}, as where logs were joined"
        mend = "remove the line" if len(at) == 1 else "remove these lines"
    elif again:
        wrong = (
            f"the columns' names stand here again{in_rows(at)}, and the times begin anew, as "
            "where the logs of two runs were joined"
        )
        mend = split
    else:
        told = " ".join(lines.text[named[0][-1]].split())[:60]
        wrong = (
            f'other names of columns stand here{in_rows(at)}, "{told}", as where logs were joined'
        )
        mend = f"{split}, and give both the same names of columns"
    raise CampaignError(lines.file, wrong, mend, at[0])


def _check_text(lines: Lines, layout: Layout, t: int | None, groups: list[list[int]]) -> None:
    """Faults rows of words, as a board writes them that was reset."""
    if not groups:
        return
    at = [lines.numbers[i] for group in groups for i in group]
    on = t is None or all(_goes_on(lines, layout, t, group) for group in groups)
    told = " ".join(lines.text[groups[0][0]].split())[:60]
    remove = "remove the line" if len(at) == 1 else "remove these lines"
    raise CampaignError(
        lines.file,
        f'words stand here and no numbers{in_rows(at)}, "{told}"'
        + ("" if on else ", and the times begin anew, as after a reset of the board"),
        remove if on else f"{remove}, and split the file there, a file for each run",
        at[0],
    )


def _groups(lines: Lines, layout: Layout) -> list[list[int]]:
    """Indices of rows without any number in a column of numbers, neighbours together."""
    groups: list[list[int]] = []
    for i in range(layout.first + 1, len(lines.text)):
        if not _WORD.search(lines.text[i]):
            continue
        cells = _cells(lines, layout, i)
        if any(j < len(cells) and is_number(cells[j], layout.decimal) for j in layout.numeric):
            if not (groups and groups[-1][-1] == i - 1 and _partly(cells, layout)):
                continue
        if groups and groups[-1][-1] == i - 1:
            groups[-1].append(i)
        else:
            groups.append([i])
    return groups


def _partly(cells: list[str], layout: Layout) -> bool:
    """True if a number is missing in a column of them, as in a title with a number in it."""
    return not all(j < len(cells) and is_number(cells[j], layout.decimal) for j in layout.numeric)


def _names(lines: Lines, layout: Layout, i: int) -> bool:
    """True if a row holds names of columns."""
    cells = _told(_cells(lines, layout, i))
    filled = [cell for cell in cells if cell]
    if len(filled) < 2 or any(is_number(cell, layout.decimal) for cell in filled):
        return False
    known = {*NAMES, *_told(layout.header)}
    width = len(_cells(lines, layout, layout.first))
    alike = len(cells) == width and all(_NAME.fullmatch(cell) for cell in filled)
    return alike or any(cell in known or parted(cell)[0] in known for cell in filled)


def _cells(lines: Lines, layout: Layout, i: int) -> list[str]:
    return split_title(lines.text[i].lstrip("\ufeff# "), layout.delimiter, layout.width)


def _same(lines: Lines, layout: Layout, group: list[int]) -> bool:
    """True if the names above the first row stand there, with nothing new, as units, below."""
    here = [_told(_cells(lines, layout, i)) for i in group]
    names = _told(layout.header) or list(NAMES[: len(here[-1])])
    if names not in here:
        return False
    above = [_told(_cells(lines, layout, i)) for i in range(layout.first)]
    return all(each in above for each in here[here.index(names) + 1 :])


def _told(cells: list[str]) -> list[str]:
    told = [cell.strip().lower() for cell in cells]
    while told and not told[-1]:
        told.pop()
    return told


def _goes_on(lines: Lines, layout: Layout, t: int, group: list[int]) -> bool:
    """True if times rise over the rows of names."""
    if group[-1] + 1 >= len(lines.text):
        return True
    pair = []
    for i in (group[0] - 1, group[-1] + 1):
        cells = _cells(lines, layout, i)
        pair.append(cells[t] if t < len(cells) else "")
    if all(is_date_or_clock(cell) for cell in pair):
        seconds, bad = seconds_since_first(pair)
        return bad is None and bool(seconds[1] > 0.0)
    values = [number(cell, layout.decimal) for cell in pair]
    return None not in values and bool(np.diff(np.array(values, dtype=float))[0] > 0.0)
