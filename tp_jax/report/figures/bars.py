"""Common parts of figures of horizontal bars: names left of them, numbers at their ends."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from tp_jax.report import layout, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BELOW = layout.SPACING.pad + layout.SPACING.line
"""Inches below axes without numbers: the label alone."""


def names(
    axes: "Axes", given: Sequence[str], width: float, bold: Sequence[bool] | None = None
) -> float:
    """One name for each bar, the first at the top.

    Args:
        given: longer ones than fit are cut.
        width: of the figure, in inches.
        bold: which stand out.

    Returns:
        The width they take, in inches.
    """
    weights = bold or [False] * len(given)
    most = layout.SPACING.names * width
    cut = [layout.shortened(n, most, bold=b) for n, b in zip(given, weights, strict=True)]
    axes.set_yticks(range(len(cut)), cut)
    for label, heavy in zip(axes.get_yticklabels(), weights, strict=True):
        if heavy:
            label.set_fontweight("bold")
    axes.tick_params(axis="y", pad=layout.SPACING.pad / layout.POINT)
    axes.invert_yaxis()
    taken = [layout.width_of([n], bold=b) for n, b in zip(cut, weights, strict=True)]
    return max(taken) + layout.SPACING.pad


def numbers(
    axes: "Axes",
    places: Iterable[float],
    ends: Sequence[float],
    texts: Sequence[str],
    size: float = style.FONT_SIZE,
) -> float:
    """One number beside the end of each bar, left of those that reach to the left.

    Returns:
        The width they take, in inches.
    """
    away = layout.SPACING.pad / layout.POINT
    for y, end, text in zip(places, ends, texts, strict=True):
        side, dx = ("left", away) if end >= 0.0 else ("right", -away)
        axes.annotate(
            text,
            (end, y),
            (dx, 0),
            textcoords="offset points",
            ha=side,
            va="center",
            fontsize=size,
            color=style.INK,
        )
    return layout.width_of(texts, size) + layout.SPACING.pad
