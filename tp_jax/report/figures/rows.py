"""Axes over one time, one above the other: their labels and their places in the figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tp_jax.report import layout

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def over_time(
    figure: "Figure", rows: "Sequence[Axes] | np.ndarray", labels: Sequence[str], above: float
) -> None:
    """Labels the rows, all at one distance, and places them.

    Args:
        labels: of the rows, in their order.
        above: inches that the legend takes.
    """
    layout.place(figure, left=layout.SPACING.line, above=above)  # the height decides on the ticks
    away = layout.numbers(rows)
    for axes, label in zip(rows, labels, strict=True):
        layout.label_left(axes, label, away)
        axes.tick_params(axis="y", pad=layout.SPACING.pad / layout.POINT)
    layout.label_below(rows[-1], "time [s]")
    layout.place(figure, left=away + layout.SPACING.line, above=above)
