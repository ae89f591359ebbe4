"""The most probable candidates: how far each alone was predicted to shrink the gap, and did."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import reading, style
from tp_jax.report.formatting import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 10
_LONGEST = 24
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
    for key, label, offset, colour in (
        ("predicted_shrink", "predicted", -0.19, style.BAND),
        ("realised_shrink", "realised after refitting", 0.19, style.AFTER),
    ):
        found = [(y + offset * _both(row), reading.value(row, key)) for y, row in enumerate(rows)]
        bars = [(y, x) for y, x in found if x is not None]
        if bars:
            places, sizes = zip(*bars, strict=True)
            drawn = [min(max(x, _LEAST), 1.0) for x in sizes]
            axes.barh(places, drawn, height=0.36, color=colour, label=label, lw=0.0)
            for y, x, end in zip(places, sizes, drawn, strict=True):
                axes.annotate(
                    percent(x), (max(end, 0.0), y), (4, 0), textcoords="offset points",
                    va="center", fontsize=style.FONT_SIZE - 1.5, color=style.INK,
                )  # fmt: skip
    axes.set_yticks(range(len(rows)), [_short(reading.text(row, "effect")) for row in rows])
    for label, row in zip(axes.get_yticklabels(), rows, strict=True):
        if reading.text(row, "effect") in accepted:
            label.set_fontweight("bold")
    axes.invert_yaxis()
    lowest = min(reading.value(row, key) or 0.0 for row in rows for key in _KEYS)
    axes.set_xlim(max(min(lowest, 0.0), _LEAST), 1.14 if width >= style.WIDE else 1.35)
    axes.set_xticks([0.0, 0.5, 1.0], ["0", "50 %", "100 %"])
    if lowest < 0.0:
        axes.axvline(0.0, color=style.INK, lw=0.8)
    axes.set_xlabel("removable gap that is gone")
    style.legend(figure, axes)
    return figure


def _both(row: Mapping[str, Any]) -> bool:
    """Whether a candidate has two bars; one alone stands in the middle."""
    return all(reading.value(row, key) is not None for key in _KEYS)


def _short(name: str) -> str:
    """A name that leaves room for the bars."""
    return name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…"
