"""Digits of a number that comes with an interval."""

import math

FEWEST, MOST = 3, 9


def digits_of(value: float, low: float, high: float) -> int:
    """Digits, counted from the largest number's first, that show two of the interval's half width.

    Example:
        >>> digits_of(375.0123, 374.9, 375.1246)
        5
    """
    largest, width = max(abs(value), abs(low), abs(high)), high - low
    if width <= 0.0 or largest == 0.0:
        return FEWEST
    wanted = math.floor(math.log10(largest)) - math.floor(math.log10(width / 2.0)) + 2
    return min(max(wanted, FEWEST), MOST)
