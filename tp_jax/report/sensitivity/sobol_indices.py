"""Total and first-order Sobol' indices of whole runs, on a scale on which nothing is nothing."""

from typing import TYPE_CHECKING

from tp_jax.report import style
from tp_jax.report.sensitivity.words import CHANNELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord

LEAST = 1e-5  # of the variance; what is below is drawn as nothing


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """Two bars for each parameter: the largest over the recordings, a column for each channel."""
    totals = analysis.sobol.total
    columns = [c for c in CHANNELS if c in totals]
    if not columns:
        return None
    names = list(totals[columns[0]])
    figure = style.new_figure(style.WIDE, 1.2 + 0.36 * len(names), fitted=True)
    grid = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    for c, axes in zip(columns, grid, strict=True):
        style.dress(axes, grid="x")
        axes.set_xscale("log")
        axes.set_xlim(LEAST, 2.0)
        for found, label, offset, colour in (
            (totals, "total: alone and with others", -0.19, style.AFTER),
            (analysis.sobol.first, "alone", 0.19, style.BAND),
        ):
            sizes = [found[c][n] or 0.0 for n in names]
            axes.barh(
                [y + offset for y in range(len(names))],
                [max(s, LEAST) for s in sizes],
                height=0.36,
                color=colour,
                label=label,
                lw=0.0,
            )
        for y, n in enumerate(names):
            size = totals[c][n] or 0.0
            axes.annotate(
                _said(size),
                (max(size, LEAST), y - 0.19),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=style.FONT_SIZE - 1.5,
                color=style.INK,
            )
        axes.set_yticks(range(len(names)), names)
        axes.set_xlabel(f"part of the variance of {CHANNELS[c]}")
    grid[0].invert_yaxis()
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper left",
        ncols=2,
        frameon=False,
        fontsize=style.FONT_SIZE,
        labelcolor=style.INK,
    )
    return figure


def _said(size: float) -> str:
    if size == 0.0:
        return "0: no effect"
    return f"{size:.2g}" if size >= 1e-3 else f"{size:.0e}"
