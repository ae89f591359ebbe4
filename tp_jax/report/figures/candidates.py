"""The most probable candidates: how far each alone was predicted to shrink the gap, and did."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import layout, reading, style
from tp_jax.report.figures import bars
from tp_jax.report.formatting import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 10
_LEAST = -0.25  # longer bars to the left end here, their numbers stand beside them
_KEYS = ("predicted_shrink", "realised_shrink")


def shown(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The candidates that the figure shows: the first ten that have a number."""
    numbered = [
        row
        for row in reading.candidates(diagnosis)
        if any(reading.value(row, key) is not None for key in _KEYS)
    ]
    return numbered[:MOST]


def draw(diagnosis: Mapping[str, Any], width: float = style.WIDE) -> "Figure | None":
    """Two bars for each candidate, accepted causes in bold.

    Returns:
        None if no candidate has a number.
    """
    rows = shown(diagnosis)
    if not rows:
        return None
    accepted = {reading.text(cause, "effect") for cause in reading.causes(diagnosis)}
    figure = style.new_figure(width, 1.0 + 0.42 * len(rows))
    axes = figure.subplots()
    style.dress(axes, grid="x")
    right = layout.width_of(["100 %"])  # half of the last tick's stands over the end
    for key, label, offset, colour in (
        ("predicted_shrink", "predicted", -0.19, style.BAND),
        ("realised_shrink", "realised after refitting", 0.19, style.AFTER),
    ):
        found = [(y + offset * _both(row), reading.value(row, key)) for y, row in enumerate(rows)]
        known = [(y, x) for y, x in found if x is not None]
        if known:
            places, sizes = zip(*known, strict=True)
            drawn = [min(max(x, _LEAST), 1.0) for x in sizes]
            axes.barh(places, drawn, height=0.36, color=colour, label=label, lw=0.0)
            ends = [max(end, 0.0) for end in drawn]
            texts = [percent(x) for x in sizes]
            right = max(right, bars.numbers(axes, places, ends, texts, style.SMALL))
    names = [reading.text(row, "effect") for row in rows]
    left = bars.names(axes, names, width, [name in accepted for name in names])
    lowest = min(reading.value(row, key) or 0.0 for row in rows for key in _KEYS)
    axes.set_xlim(max(min(lowest, 0.0), _LEAST), 1.0)
    axes.set_xticks([0.0, 0.5, 1.0], ["0", "50 %", "100 %"])
    if lowest < 0.0:
        axes.axvline(0.0, color=style.INK, lw=0.8)
    layout.label_below(axes, "removable gap that is gone")
    layout.place(figure, left=left, right=right, above=style.legend(figure, axes))
    return figure


def _both(row: Mapping[str, Any]) -> bool:
    """Whether a candidate has two bars; one alone stands in the middle."""
    return all(reading.value(row, key) is not None for key in _KEYS)
