"""Places of the parts of a figure, in inches.

Matplotlib's constrained layout draws every text several times to learn its size, which takes longer
than the drawing itself. Here margins are given, and only what differs from figure to figure is
measured: the names and numbers left of axes, and the numbers at the ends of bars.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FONT_SIZE = 9.5
"""Points, of all text but titles and the numbers at small bars."""

POINT = 1.0 / 72.0
"""Inches."""


@dataclass(frozen=True)
class Spacing:
    """Inches between the parts of a figure.

    Attributes:
        edge: around everything.
        pad: between axes and the names or numbers of their ticks, or at the end of a bar.
        line: height of a line of text with its lead: a legend's, a label's, a title's.
        ticks: from axes down to the label below the numbers of their ticks.
        over: what the last number below axes reaches over their end.
        between: axes one above the other that share what stands below them.
        names: share of the width that names left of axes may take; longer ones are cut.
    """

    edge: float = 0.05
    pad: float = 0.07
    line: float = 0.21
    ticks: float = 0.23
    over: float = 0.17
    between: float = 0.2
    names: float = 0.48


SPACING = Spacing()


def place(
    figure: "Figure",
    *,
    left: float,
    right: float = SPACING.over,
    above: float = 0.0,
    below: float = SPACING.ticks + SPACING.line,
    between: float = SPACING.between,
    beside: float = 0.0,
) -> None:
    """Puts the axes of `figure.subplots` into the figure; all in inches.

    Args:
        left, right, above, below: margins, beside the edge of the figure.
        between, beside: axes one above the other, and one beside the other.
    """
    width, height = figure.get_size_inches()
    place = figure.axes[0].get_subplotspec()
    assert place is not None  # `figure.subplots` made it
    rows, columns = place.get_gridspec().get_geometry()
    edge = SPACING.edge
    wide = width - left - right - 2.0 * edge - (columns - 1) * beside
    high = height - above - below - 2.0 * edge - (rows - 1) * between
    figure.subplots_adjust(
        left=(left + edge) / width,
        right=1.0 - (right + edge) / width,
        top=1.0 - (above + edge) / height,
        bottom=(below + edge) / height,
        wspace=columns * beside / wide,
        hspace=rows * between / high,
    )


def width_of(texts: Sequence[str], size: float = FONT_SIZE, *, bold: bool = False) -> float:
    """The widest of them [inches]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=size, weight="bold" if bold else "normal")
    widths = (text_to_path.get_text_width_height_descent(text, font, False)[0] for text in texts)
    return POINT * max(widths, default=0.0)


def shortened(text: str, inches: float, *, bold: bool = False) -> str:
    """The text, its end cut where it is wider than that."""
    if width_of([text], bold=bold) <= inches:
        return text
    while text and width_of([f"{text}…"], bold=bold) > inches:
        text = text[:-1]
    return f"{text}…"


def numbers(axes: "Sequence[Axes] | np.ndarray") -> float:
    """Width of the numbers left of these axes, with what keeps them apart [inches]."""
    found = []
    for one in axes:
        low, high = sorted(one.get_ylim())
        seen = [value for value in one.yaxis.get_major_locator()() if low <= value <= high]
        found += one.yaxis.get_major_formatter().format_ticks(seen)
    return 2.0 * SPACING.pad + width_of(found)


def label_left(axes: "Axes", text: str, away: float) -> None:
    """Writes along the axes, `away` inches left of them."""
    _label(axes, axes.yaxis, text, (0.0, 0.5), (-away, 0.0))


def label_below(axes: "Axes", text: str, *, away: float = SPACING.ticks, at: float = 0.5) -> None:
    """Writes below the axes and their numbers; `at` 0 is their left end, 1 their right one."""
    axes.xaxis.label.set_horizontalalignment(
        "left" if at == 0.0 else "right" if at == 1.0 else "center"
    )
    _label(axes, axes.xaxis, text, (at, 0.0), (0.0, -away))


def _label(axes: "Axes", axis, text: str, at: tuple[float, float], away: tuple[float, float]):
    """A place of its own keeps matplotlib from measuring all numbers of an axis for it."""
    from matplotlib.transforms import ScaledTranslation

    figure = axes.get_figure()
    assert figure is not None
    moved = ScaledTranslation(*away, figure.dpi_scale_trans)
    axis.set_label_text(text)
    axis.set_label_coords(*at, axes.transAxes + moved)
