"""Numbers as people read them: three significant digits, mrad where small, % for shares."""

import math
from collections.abc import Sequence
from typing import Any

from tp_jax._digits import digits_of
from tp_jax.schemas.checking import LARGEST

MISSING = "–"
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_SMALLEST, _LARGEST = -3, 5  # powers of ten written out


def finite(value: Any) -> float | None:
    """The value as a float; None for everything that is no number of a result."""
    if isinstance(value, bool):
        return None
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):  # a whole number of 400 digits
        return None
    return number if abs(number) <= LARGEST else None


def number(value: Any, digits: int = 3) -> str:
    """`0.580`, `52.0`, `1,230` and `1.23 × 10⁻⁵`"""
    x = finite(value)
    if x is None:
        return MISSING
    if x == 0.0:
        return "0"
    text = f"{abs(x):.{digits - 1}e}"
    mantissa, exponent = text.split("e")
    power = int(exponent)
    if _SMALLEST <= power <= _LARGEST:
        text = f"{float(text):,.{max(digits - 1 - power, 0)}f}"
    else:
        text = f"{mantissa} × 10{str(power).translate(_RAISED)}"
    return ("−" if x < 0 else "") + text


def percent(value: Any) -> str:
    """Share to `98 %`; close to 100 with one decimal, so that 100 % means all of it."""
    x = finite(value)
    if x is None:
        return MISSING
    share = 100.0 * x
    text = f"{abs(share):.1f}" if 99.5 <= share < 99.95 else f"{abs(share):,.0f}"
    return f"{'−' if share < 0 and text != '0' else ''}{text} %"


def probability(value: Any) -> str:
    """`97 %`; never certain, since no sample of models is."""
    x = finite(value)
    if x is None:
        return MISSING
    if x > 0.99:
        return "> 99 %"
    return "< 1 %" if x < 0.01 else percent(x)


def p_value(value: Any) -> str:
    """`p = 0.41` or `p < 0.001`"""
    x = finite(value)
    if x is None:
        return ""
    return "p < 0.001" if x < 0.001 else f"p = {number(x, 2)}"


def unit(text: Any) -> str:
    """`N m s^2/rad^2` with raised exponents; nothing for the unit 1."""
    said = "" if text is None else str(text).strip()
    if said in ("1", "-"):
        return ""
    return said.replace("^2", "²").replace("^3", "³")


def with_unit(value: Any, of: Any, digits: int = 3) -> str:
    """`0.450 N m/rad`"""
    return f"{number(value, digits)} {unit(of)}".rstrip()


def bounds(value: Any) -> tuple[float, float] | None:
    """Both ends of an interval; None unless there are two."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        return None
    low, high = finite(value[0]), finite(value[1])
    return None if low is None or high is None else (low, high)


def estimate(value: Any, ci95: Any) -> tuple[str, str]:
    """Value and interval, with digits enough to see the interval's width.

    The interval is an empty text where there is none.
    """
    x, ends = finite(value), bounds(ci95)
    if x is None or ends is None:
        return number(value), "" if ends is None else f"{number(ends[0])} to {number(ends[1])}"
    largest, digits = max(abs(x), abs(ends[0]), abs(ends[1])), digits_of(x, *ends)
    place = math.floor(math.log10(largest)) if largest else 0
    if _SMALLEST <= place <= _LARGEST:  # one number of decimals for all three
        decimals = max(digits - 1 - place, 0)
        said = [f"{y:,.{decimals}f}".replace("-", "−") for y in (x, *ends)]
    else:
        scale = 10.0**place
        said = [f"{y / scale:.{digits - 1}f}".replace("-", "−") for y in (x, *ends)]
        power = f" × 10{str(place).translate(_RAISED)}"
        return said[0] + power, f"{said[1]} to {said[2]}{power}"
    return said[0], f"{said[1]} to {said[2]}"


def size(value: Any, of: Any, ci95: Any, says: str = "95 % interval ") -> str:
    """`0.580 N m (95 % interval 0.550 to 0.610)`; the range of several, one for each recording.

    says: before the interval.
    """
    if isinstance(value, Sequence) and not isinstance(value, str):
        known = [x for x in map(finite, value) if x is not None]
        if not known:
            return MISSING
        ends = f"{number(min(known))} to {number(max(known))} {unit(of)}".rstrip()
        return f"{ends} over {len(known)} recordings"
    told, interval = estimate(value, ci95)
    return f"{told} {unit(of)}".rstrip() + (f" ({says}{interval})" if interval else "")


def percents(ci95: Any, negated: bool = False) -> str:
    """`96 % to 99 %`, or nothing; negated: of the opposite, as of a growth where it is a fall."""
    ends = bounds(ci95)
    if ends is not None and negated:
        ends = -ends[1], -ends[0]
    return "" if ends is None else f"{percent(ends[0])} to {percent(ends[1])}"


def angle_unit(values: Sequence[Any]) -> tuple[str, float]:
    """Unit in which these angles [rad] read well together, and the factor into it."""
    sizes = [abs(x) for x in map(finite, values) if x]
    largest = max(sizes, default=0.0)
    if largest >= 0.3:
        return "rad", 1.0
    return ("mrad", 1e3) if largest >= 1e-4 or not sizes else ("µrad", 1e6)


def angles(values: Sequence[Any]) -> list[str]:
    """Angles [rad] with one unit for all of them."""
    name, factor = angle_unit(values)
    numbers = [finite(value) for value in values]
    return [MISSING if x is None else f"{number(x * factor)} {name}" for x in numbers]


def angle(value: Any) -> str:
    """One angle [rad]."""
    return angles([value])[0]


def duration(seconds: Any) -> str:
    """`12.3 s`, `4 min 10 s`"""
    x = finite(seconds)
    if x is None:
        return MISSING
    if x < 100.0:
        return f"{number(x)} s"
    minutes, rest = divmod(round(x), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s"
