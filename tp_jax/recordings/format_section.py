"""[format] of a campaign.toml: how the data files of other makers are laid out."""

from collections.abc import Iterable
from typing import Any, cast

from tp_jax.recordings import units
from tp_jax.recordings.sections import Section, one_of
from tp_jax.recordings.sources import NAMES, REQUIRED, ColumnSource, FileFormat


def read_format(section: Section | None) -> FileFormat:
    """Reads the section [format].

    Raises:
        CampaignError: it says something that cannot be.
    """
    if section is None:
        return FileFormat()
    section.only("delimiter", "decimal", "skip_lines", "sheet", "held", "columns")
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
    # of a comma that is both the file tells: decimal commas may be in quotes
    if delimiter is not None and delimiter == decimal == ".":
        section.fault(
            f'delimiter and decimal are both "{decimal}"', "say which of them it is", "delimiter"
        )
    columns = section.section("columns")
    # without a column the names in the file stand, and only their settings are given
    found = columns is not None and not any(
        isinstance(each, dict) and "column" in each for each in columns.values.values()
    )
    return FileFormat(
        delimiter=delimiter,
        decimal=decimal,
        skip_lines=section.whole("skip_lines"),
        columns={} if columns is None or found else _columns(columns),
        sheet=section.text("sheet"),
        held=bool(section.flag("held")),
        changes=read_changes(columns) if found else {},
    )


def read_changes(section: Section | None) -> dict[str, dict[str, Any]]:
    """Settings of columns that are found otherwise, name -> setting -> value.

    Raises:
        CampaignError: it says something that cannot be.
    """
    if section is None:
        return {}
    section.only(*NAMES)
    found = {}
    for name in section.values:
        source = _column(section, name, whole=False)
        _check_minus(section, name, source, NAMES)
        given = cast(Section, section.section(name)).values
        found[name] = {key: getattr(source, key) for key in given}
    return found


def _columns(columns: Section) -> dict[str, ColumnSource]:
    columns.only(*NAMES)
    for name in REQUIRED:
        if name not in columns.values:
            columns.fault(
                f"{columns.title} does not say where {name} is", f"add {name} = {{ column = 0 }}"
            )
    sources = {name: _column(columns, name) for name in columns.values}
    for name, source in sources.items():
        _check_minus(columns, name, source, sources)
    return sources


def _check_minus(columns: Section, name: str, source: ColumnSource, others: Iterable[str]) -> None:
    """Faults a column that is counted from itself, or from none of the others."""
    if source.minus is None or (source.minus != name and source.minus in others):
        return
    columns.fault(
        f'minus of {name} is "{source.minus}", which is no other column of {columns.title}',
        "remove it" if name in REQUIRED else 'write minus = "phi1"',
        name,
    )


def _column(columns: Section, name: str, whole: bool = True) -> ColumnSource:
    """The source of a column; `whole`: it must say which column it is."""
    section = cast(Section, columns.section(name))
    section.only("column", "unit", "counts", "wrap", "minus", "scale", "offset", "summer_time")
    column = section.values.get("column")
    if isinstance(column, int):
        column = section.whole("column")
    if column is None and not whole and "column" not in section.values:
        column = name
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
    summer_time = bool(section.flag("summer_time"))
    if summer_time and name != "t":
        section.fault(
            f"summer_time of {name} is given, but {name} is no time", "remove it", "summer_time"
        )
    return ColumnSource(
        column,
        1.0 if scale is None else scale,
        offset or 0.0,
        unit,
        counts,
        _wrap(section, name),
        section.text("minus"),
        summer_time,
    )


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


def _wrap(section: Section, name: str) -> float | bool | None:
    """Reads after how many of its units a reading starts anew; True: it is to be found out."""
    value = section.values.get("wrap")
    if value is None or value is False:
        return None
    if not units.of(name):
        section.fault(f"wrap of {name} is given, but {name} is no angle", "remove it", "wrap")
    return True if value is True else section.positive("wrap")
