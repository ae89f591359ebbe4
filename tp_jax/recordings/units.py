"""Units that a campaign.toml may name, and what a reading becomes in seconds, radians, rad/s."""

import math
import re
from collections.abc import Mapping

TIME: Mapping[str, float] = {
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "µs": 1e-6,
    "μs": 1e-6,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
"""Unit of a time -> seconds."""

ANGLE: Mapping[str, float] = {
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": math.pi / 180.0,
    "°": math.pi / 180.0,
    "gon": math.pi / 200.0,
    "turn": 2.0 * math.pi,
    "rev": 2.0 * math.pi,
}
"""Unit of an angle -> radians. Counts of an encoder have a key of their own, `counts`."""

FREQUENCY: Mapping[str, float] = {
    "rad/s": 1.0,
    "Hz": 2.0 * math.pi,
    "mHz": 2e-3 * math.pi,
    "rpm": math.pi / 30.0,
    "1/min": math.pi / 30.0,
    "deg/s": math.pi / 180.0,
    "°/s": math.pi / 180.0,
}
"""Unit of the drive's frequency -> rad/s."""

_OTHER_NAMES = {
    "sec": "s",
    "seconds": "s",
    "second": "s",
    "sek": "s",
    "sekunde": "s",
    "sekunden": "s",
    "secs": "s",
    "msec": "ms",
    "millis": "ms",
    "millisecond": "ms",
    "milliseconds": "ms",
    "millisekunden": "ms",
    "usec": "us",
    "micros": "us",
    "microsecond": "us",
    "microseconds": "us",
    "mikrosekunden": "us",
    "nanoseconds": "ns",
    "radians": "rad",
    "radian": "rad",
    "rads": "rad",
    "radiant": "rad",
    "milliradians": "mrad",
    "degrees": "deg",
    "degree": "deg",
    "degs": "deg",
    "grad": "deg",
    "º": "deg",
    "˚": "deg",
    "gons": "gon",
    "turns": "turn",
    "revs": "rev",
    "hz": "Hz",
    "u/min": "rpm",
    "min^-1": "rpm",
    "minute": "min",
    "minutes": "min",
    "minuten": "min",
    "hours": "h",
}
"""Other names that files and people write for units. German "Grad" is a degree."""

_IN_HEADER = re.compile(r"^(?P<name>.*?)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\)|/\s*(?P<c>\S+))$")


def named(text: str, units: Mapping[str, float]) -> str | None:
    """The unit that a text names, as the table spells it; None where it names none of them.

    Capitals and a dot at the end do not matter, but "M" is mega, no milli: of the units with such
    a prefix only those of time may be in capitals, since no rig counts megaseconds.

    Example:
        >>> named("Deg.", ANGLE), named("MHz", FREQUENCY)
        ('deg', None)
    """
    text = text.strip()
    if text in units:
        return text
    plain = text.lower().removesuffix(".").removesuffix("(s)")
    lower = {unit.lower(): unit for unit in units}
    found = lower.get(plain) or _OTHER_NAMES.get(plain)
    mega = text.startswith("M") and plain in ("mrad", "mhz")
    return None if mega or found not in units else found


def of(column: str) -> Mapping[str, float]:
    """Units that a column of a recording may be in; the drive's reading has none."""
    return TIME if column == "t" else {} if column == "drive" else ANGLE


def parted(cell: str) -> tuple[str, str]:
    """A header's cell as name and unit: "t [ms]", "t (ms)" and "t/ms" are ("t", "ms").

    The unit is "" where there is none.

    Example:
        >>> parted("phi1 [deg]")
        ('phi1', 'deg')
    """
    match = _IN_HEADER.match(cell.strip())
    if match is None:
        return cell.strip(), ""
    return match["name"], (match["a"] or match["b"] or match["c"] or "").strip()
