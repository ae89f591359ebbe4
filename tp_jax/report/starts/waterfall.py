"""Ends of the starts, best first: a plateau at the bottom is the optimum found again."""

from typing import TYPE_CHECKING

import numpy as np

from tp_jax.estimation.identification import Identification
from tp_jax.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FLOOR = 1e-2  # of chi-square: below it two ends are one


def waterfall(result: Identification) -> "Figure":
    """Chi-square above the best by start, on a logarithmic scale; failed starts stand apart."""
    from matplotlib.ticker import MaxNLocator

    ends = np.array([t.end.cost for t in result.trials])
    order = np.argsort(ends, kind="stable")
    above = ends[order] - np.min(ends)
    there = np.isfinite(above)
    height = np.where(there, np.maximum(above, FLOOR), np.nan)
    top = 10.0 * float(np.nanmax(height)) if there.any() else 1.0
    place = np.arange(1, ends.size + 1)
    reached = there & (above <= 1.0)

    figure = style.new_figure(style.BESIDE, 3.2, fitted=True)
    axes = figure.subplots()
    style.dress(axes)
    axes.plot(place[there], height[there], color=style.BAND, lw=0.8, zorder=1)
    for chosen, color, marker, label in (
        (reached, style.AFTER, "o", "reached the best"),
        (there & ~reached, style.BEFORE, "s", "ended elsewhere"),
    ):
        if chosen.any():
            axes.plot(
                place[chosen],
                height[chosen],
                color=color,
                marker=marker,
                ls="",
                ms=5,
                mew=0.0,
                label=label,
            )
    if (~there).any():
        axes.plot(
            place[~there],
            np.full((~there).sum(), top),
            color=style.MUTED,
            marker="x",
            ls="",
            ms=5,
            label="came to nothing",
        )
    axes.axhline(1.0, color=style.MUTED, lw=0.8, ls="--")
    axes.set_yscale("log")
    axes.set_xlabel("start, best first")
    axes.set_ylabel("χ² above the best")
    places = axes.xaxis.get_major_locator()
    assert isinstance(places, MaxNLocator)
    places.set_params(integer=True)
    style.legend(figure, axes)
    return figure
