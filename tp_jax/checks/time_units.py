"""Units of times beside the one that was said: their names, and what to write for them."""

import math

from tp_jax.recordings import Recording
from tp_jax.recordings.sources import ColumnSource
from tp_jax.recordings.units import TIME

NAMES = {
    "s": "seconds",
    "ms": "milliseconds",
    "us": "microseconds",
    "ns": "nanoseconds",
    "min": "minutes",
}
"""Units that times are in, and their names."""


def source_of(recording: Recording) -> ColumnSource:
    """Source of a recording's times."""
    return recording.sources.get("t", ColumnSource("t"))


def others(source: ColumnSource) -> dict[str, float]:
    """Units but for the one that was said, each over that one."""
    said = source.factor("t")
    return {u: TIME[u] / said for u in NAMES if not math.isclose(TIME[u], said)}


def over_said(source: ColumnSource, factor: float) -> str | None:
    """The unit that is so many of the one that was said; None where none of these is."""
    alike = (u for u, each in others(source).items() if math.isclose(each, factor))
    return next(alike, None)


def in_place(source: ColumnSource) -> str:
    """Says that a scale, where one was said, goes when the unit comes."""
    return "" if source.scale == 1.0 else ", without its scale"
