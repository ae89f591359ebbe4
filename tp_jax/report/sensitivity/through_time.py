"""Importance of parameters through time: a row of light for each, from nothing to plain to see."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tp_jax.report import style
from tp_jax.report.sensitivity.words import CHANNELS, short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord

MOST = 6
NEIGHBOURS = 2
LEAST = 1e-2  # noise levels for one per cent; below, a parameter is dark: nobody sees it


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """A block for each recording and channel, all on one logarithmic scale."""
    from matplotlib.colors import LogNorm

    recordings = analysis.local.recordings[:MOST]
    if not recordings:
        return None
    columns = list(recordings[0].channels)
    noise = analysis.quality.noise_floor
    names = list(recordings[0].channels[columns[0]])
    blocks = {
        (i, c): _smooth(np.array([r.channels[c][n] for n in names], float)) / 100.0 / noise[c]
        for i, r in enumerate(recordings)
        for c in columns
    }
    top = max(float(b.max()) for b in blocks.values())
    norm = LogNorm(LEAST, max(top, 10.0 * LEAST))
    height = 1.0 + len(recordings) * (0.35 + 0.16 * len(names))
    figure = style.new_figure(style.WIDE, height, fitted=True)
    grid = figure.subplots(len(recordings), len(columns), squeeze=False)
    image: Any = None
    for i, r in enumerate(recordings):
        t = np.array(r.t)
        for c, axes in zip(columns, grid[i], strict=True):
            style.dress(axes, grid=None)
            image = axes.imshow(
                np.maximum(blocks[i, c], LEAST),
                norm=norm,
                cmap=style.SCALE,
                aspect="auto",
                interpolation="nearest",
                extent=(t[0], t[-1], len(names) - 0.5, -0.5),
            )
            axes.set_yticks(range(len(names)), names)
            axes.tick_params(axis="y", labelsize=style.FONT_SIZE - 1.5)
            style.title(axes, f"{short(r.recording)}, {CHANNELS[c]}")
            if i + 1 < len(recordings):
                axes.tick_params(labelbottom=False)
            else:
                axes.set_xlabel("time [s]")
    bar = figure.colorbar(image, ax=grid, pad=0.01, fraction=0.03, extend="min")
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=style.FONT_SIZE, labelcolor=style.INK, length=0.0)
    bar.set_label(
        "change of the angle for 1 % of the parameter [noise]",
        size=style.FONT_SIZE,
        color=style.INK,
    )
    return figure


def _smooth(rows: np.ndarray) -> np.ndarray:
    """Root of the mean square over neighbouring times: an angle's zeros are no lack of effect."""
    square = np.pad(rows**2, ((0, 0), (NEIGHBOURS, NEIGHBOURS)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(square, 2 * NEIGHBOURS + 1, axis=1)
    return np.sqrt(windows.mean(axis=2))
