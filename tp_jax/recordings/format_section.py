"""[format] of a campaign.toml: how the data files of other makers are laid out."""

import math
from typing import cast

from tp_jax.recordings import units
from tp_jax.recordings.sections import Section, one_of
from tp_jax.recordings.sources import NAMES, REQUIRED, ColumnSource, FileFormat


def read_format(section: Section | None) -> FileFormat:
    """What [format] says.

    Raises:
        CampaignError: it says something that cannot be.
    """
    if section is None:
        return FileFormat()
    section.only("delimiter", "decimal", "skip_lines", "sheet", "columns")
    delimiter = section.text("delimiter")
    if delimiter is not None and (len(delimiter) != 1 or delimiter in "\r\n"):
        section.fault(
            "the delimiter is not one character", 'write delimiter = "," or "\\t"', "delimiter"
        )
    decimal = section.text("decimal")
    if decimal not in (None, ".", ","):
        section.fault(
            f'the decimal sign is "{decimal}"', 'write decimal = "." or decimal = ","', "decimal"
        )
    if delimiter is not None and delimiter == decimal:
        section.fault(
            f'delimiter and decimal are both "{decimal}"', "say which of them it is", "delimiter"
        )
    columns = section.section("columns")
    return FileFormat(
        delimiter=delimiter,
        decimal=decimal,
        skip_lines=section.whole("skip_lines"),
        columns={} if columns is None else _columns(columns),
        sheet=section.text("sheet"),
    )


def _columns(columns: Section) -> dict[str, ColumnSource]:
    columns.only(*NAMES)
    for name in REQUIRED:
        if name not in columns.values:
            columns.fault(
                f"{columns.title} does not say where {name} is", f"add {name} = {{ column = 0 }}"
            )
    sources = {name: _column(columns, name) for name in columns.values}
    for name, source in sources.items():
        if source.minus is not None and (source.minus == name or source.minus not in sources):
            columns.fault(
                f'minus of {name} is "{source.minus}", which is no other column of {columns.title}',
                'write minus = "phi1"',
                name,
            )
    return sources


def _column(columns: Section, name: str) -> ColumnSource:
    section = cast(Section, columns.section(name))
    section.only("column", "unit", "counts", "wrap", "minus", "scale", "offset")
    column = section.values.get("column")
    if isinstance(column, int):
        column = section.whole("column")
    if column is None or not isinstance(column, int | str):
        columns.fault(
            f"{name} in {columns.title} lacks the column it comes from",
            f'write {name} = {{ column = 0 }} or {name} = {{ column = "its name" }}',
            name,
        )
    scale, offset = section.number("scale"), section.number("offset")
    if scale == 0.0:
        columns.fault(f"the scale of {name} is 0", "give another or remove it", name)
    unit, counts = _unit(columns, section, name), section.positive("counts")
    if counts is not None and (unit is not None or units.of(name) is not units.ANGLE):
        columns.fault(
            f"counts of {name} is given, but {name} is "
            + ("in a unit already" if unit is not None else "no angle"),
            "remove one of the two" if unit is not None else "remove it",
            name,
        )
    source = ColumnSource(
        column, 1.0 if scale is None else scale, offset or 0.0, unit, counts,
        minus=section.text("minus"),
    )  # fmt: skip
    wrap = _wrap(section, source, name)
    return source if wrap is None else ColumnSource(**{**vars(source), "wrap": wrap})


def _unit(columns: Section, section: Section, name: str) -> str | None:
    text, table = section.text("unit"), units.of(name)
    if text is None:
        return None
    unit = units.named(text, table)
    if unit is None:
        columns.fault(
            f'the unit of {name} is "{text}"',
            one_of(table) if table else "remove it, the drive is known up to a gain",
            name,
        )
    return unit


def _wrap(section: Section, source: ColumnSource, name: str) -> float | None:
    """After how many of the cell's units a reading starts anew; true: after a turn."""
    value = section.values.get("wrap")
    if value is None or value is False:
        return None
    if units.of(name) is not units.ANGLE:
        section.fault(f"wrap of {name} is given, but {name} is no angle", "remove it", "wrap")
    if value is True:
        return abs(2.0 * math.pi / source.factor(name))
    return section.positive("wrap")
