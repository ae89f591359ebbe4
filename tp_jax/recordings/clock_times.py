"""Times written as dates or clock times, to seconds from the first of them."""

import re
from datetime import datetime

import numpy as np

_CLOCK = re.compile(r"(\d{1,2}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?")
_GERMAN = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T]+(\d.*)")
_DAY = 86400.0


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
    clock = _CLOCK.fullmatch(cell)
    if clock is not None:
        seconds = float((clock[3] or "0").replace(",", "."))
        return 3600.0 * int(clock[1]) + 60.0 * int(clock[2]) + seconds
    german = _GERMAN.fullmatch(cell)
    if german is not None:
        cell = f"{german[3]}-{int(german[2]):02d}-{int(german[1]):02d}T{german[4]}"
    if ":" not in cell:
        return None
    try:
        return datetime.fromisoformat(cell.replace(",", "."))
    except ValueError:
        return None
