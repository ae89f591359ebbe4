"""Likelihood profiles: how much worse the fit is where one parameter is held off its best."""

from typing import TYPE_CHECKING

import numpy as np

from tp_jax.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord

COLUMNS = 3


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """One curve for each profile; dashed the level below which values are not rejected."""
    found = analysis.profile
    if not found:
        return None
    rows = -(-len(found) // COLUMNS)
    figure = style.new_figure(style.WIDE, 0.4 + 2.4 * rows, fitted=True)
    grid = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for axes, (name, p) in zip(grid, found.items(), strict=False):
        style.dress(axes)
        x, y = np.array(p.values, float), np.array(p.drops, float) / p.level
        smooth = np.linspace(x[0], x[-1], 200)
        axes.plot(smooth, _between(x, y, smooth), color=style.AFTER, lw=1.4)
        axes.plot(x, y, ls="", marker="o", ms=3.5, color=style.AFTER, mew=0.0)
        axes.axhline(1.0, color=style.INK, lw=1.0, ls=(0, (2, 2)))
        for end in p.ci95:
            if end is not None:
                axes.axvline(end, color=style.BAND, lw=0.8)
        axes.set_ylim(-0.05, 2.0)
        axes.locator_params(axis="x", nbins=4)
        style.title(axes, f"{name} [{p.unit}]")
    for axes in grid[len(found) :]:
        axes.set_visible(False)
    figure.supylabel("misfit over its critical value", fontsize=style.FONT_SIZE, color=style.INK)
    return figure


def _between(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Signed roots of a profile are nearly straight, so they are what is interpolated."""
    best = int(np.argmin(y))
    root = np.sqrt(np.maximum(y, 0.0)) * np.where(np.arange(len(x)) < best, -1.0, 1.0)
    return np.interp(at, x, root) ** 2
