"""Correlations of the estimates: pairs near 1 or -1 are known only together."""

from typing import TYPE_CHECKING

import numpy as np

from tp_jax.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord

TOLD = 0.3  # sizes from which on a number stands in its cell


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """The matrix, from vermillion (-1) over white to blue (1)."""
    from matplotlib.colors import LinearSegmentedColormap

    names = analysis.correlation.names
    matrix = np.array(analysis.correlation.matrix, float)
    if not names:
        return None
    map_ = LinearSegmentedColormap.from_list("signed", [style.BEFORE, "white", style.AFTER])
    side = 1.6 + 0.42 * len(names)
    figure = style.new_figure(side + 0.6, side, fitted=True)
    axes = figure.subplots()
    style.dress(axes, grid=None)
    image = axes.imshow(matrix, cmap=map_, vmin=-1.0, vmax=1.0)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    for i, j in np.ndindex(matrix.shape):
        if i != j and abs(matrix[i, j]) >= TOLD:
            axes.text(
                j,
                i,
                f"{matrix[i, j]:.2f}".replace("-", "−"),
                ha="center",
                va="center",
                fontsize=style.FONT_SIZE - 2.5,
                color="white" if abs(matrix[i, j]) > 0.75 else style.INK,
            )
    bar = figure.colorbar(image, ax=axes, pad=0.02, fraction=0.04)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=style.FONT_SIZE, labelcolor=style.INK, length=0.0)
    bar.set_label("correlation of the estimates", size=style.FONT_SIZE, color=style.INK)
    return figure
