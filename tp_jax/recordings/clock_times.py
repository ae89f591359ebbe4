"""Times written as dates or clock times, to seconds from the first of them."""

import re
from datetime import datetime

import numpy as np

_CLOCK = re.compile(
    r"(\d{1,2}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?(?:\s*([ap])\.?m\.?)?\s*(Z|[+-]\d{2}(?::?\d{2})?)?",
    re.IGNORECASE,
)
_DATE = re.compile(
    r"(?:(\d{4})([-/])(\d{1,2})\2(\d{1,2})|(\d{1,2})\.(\d{1,2})\.(\d{4}))[ T]+(\d.*)"
)
_DAY_OR_MONTH = re.compile(r"\d{1,2}([/-])\d{1,2}\1(?:\d{2}|\d{4})\b.*")
_DAY = 86400.0

FORMS = (
    "write dates as 2026-11-23 10:15:30.004, 2026/11/23 10:15:30.004 or 23.11.2026 10:15:30.004, "
    "or clock times as 10:15:30.004, each with AM or PM or without"
)
"""Forms that are read, as a mend."""


def day_or_month(cell: str) -> bool:
    """True if a cell is a date of which nobody knows where the day is, "11/12/2026"."""
    return _DAY_OR_MONTH.fullmatch(cell.strip()) is not None


def has_zone(cell: str) -> bool:
    """True if a cell is a date whose offset from UTC is told, so that no summer time is in it."""
    value = _seconds(cell)
    return isinstance(value, datetime) and value.tzinfo is not None


def is_date_or_clock(cell: str) -> bool:
    """True if a cell reads as a date with a time, or as the time of a day."""
    return _seconds(cell) is not None


def seconds_since_first(cells: list[str]) -> tuple[np.ndarray, int | None]:
    """Seconds from the first cell; midnight may lie between clock times.

    Args:
        cells: n texts, "2026-11-23T10:15:30.004Z", "23.11.2026 10:15:30,004" or "10:15:30.004".

    Returns:
        (n,) seconds, and the index of the first cell that is none of these (None: all are).
    """
    found = np.zeros(len(cells))
    base: datetime | None = None
    for i, cell in enumerate(cells):
        value = _seconds(cell)
        if value is None or (base is None and i and isinstance(value, datetime)):
            return found, i
        if isinstance(value, datetime):
            base = base or value
            try:
                found[i] = (value - base).total_seconds()
            except TypeError:  # one with a time zone, the other without
                return found, i
        elif base is not None:
            return found, i
        else:
            found[i] = value
    if base is None:
        found = found + _DAY * np.concatenate([[0.0], np.cumsum(np.diff(found) < -0.5 * _DAY)])
    return found - found[0], None


def _seconds(cell: str) -> datetime | float | None:
    cell = cell.strip()
    if ":" not in cell:
        return None
    date = _DATE.fullmatch(cell)
    clock = _CLOCK.fullmatch(cell if date is None else date[8])
    if clock is None:
        return _iso(cell)
    hour, seconds = int(clock[1]), (clock[3] or "00").replace(",", ".")
    if clock[4]:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if clock[4] in "pP" else 0)
    if date is not None:
        year, month, day = date[1] or date[7], date[3] or date[6], date[4] or date[5]
        zone = (clock[5] or "").upper()
        return _iso(f"{year}-{month:0>2}-{day:0>2}T{hour:02d}:{clock[2]}:{seconds}{zone}")
    if clock[5]:  # an offset without a date
        return None
    return 3600.0 * hour + 60.0 * int(clock[2]) + float(seconds)


def _iso(cell: str) -> datetime | None:
    try:
        return datetime.fromisoformat(cell.replace(",", "."))
    except ValueError:
        return None
