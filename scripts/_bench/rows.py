"""Rows of the table, and the bars they are held against."""

import math
from typing import NamedTuple

#: What is asked for, in words and as a number; a value is to stay at or below it. Ratios of costs
#: are ours over the other's, so that one means as fast.
BARS = {
    "sweep over cvodes": ("1/50 of CasADi CVODES", 1.0 / 50.0),
    "sweep over numba": ("1/2 of numba-dopri5", 1.0 / 2.0),
    "single over cvodes": ("1/3 of CasADi CVODES", 1.0 / 3.0),
    "single over tsit5": ("no slower than diffrax-tsit5", 1.0),
    "sensitivities over run": ("6 × the run alone", 6.0),
    "sensitivities over cvodes": ("1/30 of CasADi CVODES", 1.0 / 30.0),
    "tangents": ("derivatives to 1 %", 1e-2),
    "stuck": ("2 × sliding", 2.0),
    "slope": ("1.5 × that at the smallest ε", 1.5),
    "lost": ("none lost", 0.0),
    "slowest": ("steps within 20 × the median", 20.0),
    "scaling": ("per lane 1.2 × that of 256 lanes", 1.2),
    "shell": ("2.5 s", 2.5),
    "diagnosis cold": ("90 s", 90.0),
    "diagnosis warm": ("20 s", 20.0),
    "diagnosis memory": ("2 GB", 2.0),
    "rates ratio": ("2.5 × in CPU time", 2.5),
    "growth memory": ("4 GB", 4.0),
    "simplices over scipy": ("1/30 of SciPy with CVODES", 1.0 / 30.0),
}


class Row(NamedTuple):
    """One line of the table.

    measure, case, who: what it is about. value: in words. bar: in words, empty where none is set.
    reached: None without a bar. margin: value over bar, below one where it is reached.
    """

    measure: str
    case: str
    who: str
    value: str
    bar: str = ""
    reached: bool | None = None
    margin: float | None = None


def plain(measure: str, case: str, who: str, value: str) -> Row:
    """A row without a bar."""
    return Row(measure, case, who, value)


def held(bar: str, measure: str, case: str, who: str, number: float, value: str) -> Row:
    """A row whose number is held against a bar."""
    words, limit = BARS[bar]
    if limit:
        margin = number / limit
    else:
        margin = 0.0 if number <= 0.0 else math.inf
    return Row(measure, case, who, value, words, number <= limit, margin)


def times(factor: float) -> str:
    """A ratio in words, to go before what it is of: "1/83 of", "1.2 ×"."""
    return f"1/{1.0 / factor:.3g} of" if 0.0 < factor < 1.0 else f"{factor:.3g} ×"


def duration(seconds: float) -> str:
    """Seconds with a unit, three digits."""
    if not math.isfinite(seconds):
        return "failed"
    if seconds >= 1.0:
        return f"{seconds:.3g} s"
    return f"{1e3 * seconds:.3g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.3g} µs"


def smoothing(eps: float) -> str:
    """The case's name for a slope."""
    return f"ε = {eps:g} s"
