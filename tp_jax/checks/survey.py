"""What a data file of unknown make holds: its columns, and which of them may be what.

Everything here is a guess, written down by `tp-jax init` for the user to correct.
"""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tp_jax.checks.policy import SamplingPolicy
from tp_jax.recordings import units
from tp_jax.recordings.cells import parse, split
from tp_jax.recordings.checks import WIDEST_PHI1
from tp_jax.recordings.clock_times import is_date_or_clock
from tp_jax.recordings.encoder import leaps, whole_numbers
from tp_jax.recordings.faults import CampaignError
from tp_jax.recordings.kinds import kind_of
from tp_jax.recordings.layout import layout_of
from tp_jax.recordings.lines import as_lines, read_bytes
from tp_jax.recordings.sources import NAMES, ColumnSource, FileFormat
from tp_jax.recordings.tables import as_numbers, read_named

_WORDS = {
    "t": r"t|time\w*|zeit\w*|sec|seconds|sekunden|timestamp|zeitstempel|tijd|temps|czas",
    "phi1": r"phi_?1|φ1|theta_?1|angle_?1|winkel_?1|ang1|enc(oder)?_?1|column|säule|disk_?1",
    "phi2": r"phi_?2|φ2|theta_?2|angle_?2|winkel_?2|ang2|enc(oder)?_?2|rider|ring|reiter|disk_?2",
    "drive": r"drive|antrieb|motor\w*|erreger\w*|excit\w*|force|f_?e",
}
"""What people call the columns, in the languages that turned up."""

_MEND = "leave it out, or export it as CSV"


@dataclass(frozen=True)
class Survey:
    """What was found in a file.

    Attributes:
        delimiter, decimal: of a text; None for files of other kinds.
        header: whether the columns have names.
        sources: name in the recording -> where it seems to be, with its unit.
        why: name in the recording -> what speaks for it, in words.
        t, phi1: as the sources give them.
    """

    delimiter: str | None
    decimal: str | None
    header: bool
    sources: dict[str, ColumnSource]
    why: dict[str, str]
    t: np.ndarray
    phi1: np.ndarray


def survey(file: Path) -> Survey:
    """Looks at a data file.

    Raises:
        CampaignError: it cannot be read, or has no two columns of numbers.
    """
    raw = read_bytes(file)
    kind = kind_of(file, raw[:4096])
    if kind is not None:
        table = read_named(file, kind, None)
        names, told = list(table), [units.parted(name)[1] for name in table]
        columns = {}
        for i, name in enumerate(names):
            try:
                columns[i] = as_numbers(file, "t", table[name])
            except CampaignError:  # texts
                continue
        dates = {i for i, n in enumerate(names) if table[n].dtype.kind in "Mm"}
        layout = None
    else:
        lines = as_lines(file, raw)
        layout = layout_of(lines, FileFormat())
        if layout.first >= len(lines.text):
            raise CampaignError(file, "there are no rows of numbers in it", _MEND)
        names = layout.header
        below = layout.below
        width = len(split(lines.text[layout.first], layout.delimiter))
        told = [
            (units.parted(names[i])[1] if i < len(names) else "")
            or (below[i].strip("[]() ") if i < len(below) else "")
            for i in range(width)
        ]
        columns, dates = {}, set()
        for i in layout.numeric:
            first = split(lines.text[layout.first], layout.delimiter)[i]
            if is_date_or_clock(first):
                dates.add(i)
            columns[i] = parse(
                lines, layout.first, {"t": i}, layout.delimiter, layout.decimal, layout.like
            )["t"]
    if len(columns) < 2:
        raise CampaignError(file, "there are no two columns of numbers in it", _MEND)
    which = _which(names, columns)
    sources, why = {}, {}
    for name, i in which.items():
        column = names[i] if i < len(names) and names.count(names[i]) == 1 else i
        unit = units.named(told[i], units.of(name)) if i < len(told) and told[i] else None
        sources[name], why[name] = _source(name, column, unit, columns, which, i in dates)
    values = {name: sources[name].apply(name, columns[which[name]]) for name in ("t", "phi1")}
    return Survey(
        None if layout is None else layout.delimiter or " ",
        None if layout is None else layout.decimal,
        bool(names), sources, why, values["t"], values["phi1"],
    )  # fmt: skip


def _which(names: list[str], columns: dict[int, np.ndarray]) -> dict[str, int]:
    """Name in the recording -> index of the column that seems to hold it."""
    found: dict[str, int] = {}
    for name, words in _WORDS.items():
        for i in columns:
            bare = units.parted(names[i])[0].strip('"').lower() if i < len(names) else ""
            if i not in found.values() and re.fullmatch(words, bare):
                found[name] = i
                break
    rising = [i for i, x in columns.items() if x.size > 1 and np.all(np.diff(x) > 0.0)]
    if "t" not in found:
        left = [i for i in rising if i not in found.values()]
        found["t"] = (left or [i for i in columns if i not in found.values()])[0]
    for name in ("phi1", "phi2"):
        # a column that only rises is a number of rows
        left = [i for i in columns if i not in found.values() and i not in rising]
        if name not in found and left:
            found[name] = left[0]
    if "phi1" not in found:
        found["phi1"] = next(i for i in columns if i != found["t"])
    return {name: found[name] for name in NAMES if name in found}


def _source(
    name: str,
    column: str | int,
    unit: str | None,
    columns: dict[int, np.ndarray],
    which: dict[str, int],
    is_date: bool,
) -> tuple[ColumnSource, str]:
    cells = columns[which[name]]
    source = ColumnSource(column, unit=unit)
    if name == "drive":
        return source, ""
    if unit is not None:
        why = "the file says so"
    elif name == "t":
        if is_date:
            return source, "dates or clock times, in seconds from the first"
        step = float(np.median(np.diff(cells)))
        guess = "us" if step >= 500.0 else "ms" if step > SamplingPolicy().longest_step else None
        return replace(source, unit=guess), f"steps of {step:.4g}"
    else:
        width = float(np.ptp(cells))
        if whole_numbers(cells):
            counts = 2.0 ** max(8, int(np.ceil(np.log2(width + 1.0))))
            source = replace(source, counts=counts)
            why = f"whole numbers that span {width:g}; correct the counts of a whole turn"
        elif width > WIDEST_PHI1:
            source, why = replace(source, unit="deg"), f"spans {width:.4g}"
        else:
            why = f"spans {width:.4g}"
    if name != "t":
        leap = leaps(columns[which["t"]], cells)
        if leap is not None and leap.period is not None:
            if source.counts is not None:
                source = replace(source, counts=leap.period)
            source = replace(source, wrap=leap.period)
            why += f", starts anew after {leap.period:g}"
    return source, why
