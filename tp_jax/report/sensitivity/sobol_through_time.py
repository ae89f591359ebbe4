"""Shares of the parameters in the spread of a motion, at each moment."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tp_jax.report import style
from tp_jax.report.sensitivity.words import CHANNELS, short

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord, SobolOfChannel, SobolRun

MOST = 3
#: Okabe and Ito's others, with the two of the report, for what matters most.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7a00", "#444c56")


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """First-order indices stacked over time, in parts of the standard deviation of the angle.

    What stays white below the dashed line is the doing of several together.
    """
    recordings = _most_varied(analysis.sobol.recordings)
    if not recordings:
        return None
    columns = list(recordings[0].channels)
    names = list(recordings[0].channels[columns[0]].total)
    order = sorted(
        names, key=lambda n: -max(_size(r.channels[c], n) for r in recordings for c in columns)
    )
    colour = {n: COLOURS[i] for i, n in enumerate(order[: len(COLOURS)])}
    figure = style.new_figure(style.WIDE, 0.9 + 1.9 * len(recordings), fitted=True)
    grid = figure.subplots(len(recordings), len(columns), squeeze=False)
    for r, line in zip(recordings, grid, strict=True):
        t = np.array(r.t)
        for c, axes in zip(columns, line, strict=True):
            style.dress(axes)
            table = r.channels[c].through_time
            spread = 1e3 * np.sqrt(np.array(table.variance, float))
            parts = {n: np.nan_to_num(np.array(table.first[n], float)) for n in order}
            below = np.zeros_like(spread)
            for n in order:
                above = below + np.clip(parts[n], 0.0, 1.0) * spread
                axes.fill_between(t, below, above, color=colour.get(n, style.BAND), lw=0.0)
                below = above
            axes.plot(t, spread, color=style.INK, lw=1.0, ls=(0, (3, 2)))
            axes.set_ylim(0.0)
            axes.margins(x=0.0)
            style.title(axes, f"{short(r.recording)}, {CHANNELS[c]}")
            if line is grid[-1]:
                axes.set_xlabel("time [s]")
    for line in grid:
        line[0].set_ylabel("spread [mrad]")
    _legend(figure, order, colour)
    return figure


def _legend(figure: "Figure", order: list[str], colour: Mapping[str, str]) -> None:
    from matplotlib.patches import Patch

    handles = [Patch(color=colour[n], lw=0.0, label=n) for n in order if n in colour]
    rest = [n for n in order if n not in colour]
    if rest:
        handles.append(Patch(color=style.BAND, lw=0.0, label=" ".join(rest)))
    figure.legend(
        handles=handles,
        loc="outside upper left",
        ncols=10,
        frameon=False,
        fontsize=style.FONT_SIZE,
        labelcolor=style.INK,
        handlelength=1.0,
        columnspacing=1.2,
    )


def _size(entry: "SobolOfChannel", name: str) -> float:
    return entry.total[name] or 0.0


def _most_varied(recordings: "Sequence[SobolRun]") -> "list[SobolRun]":
    """The recordings in which the last channel spreads most, in their own order."""

    def spread(r: "SobolRun") -> float:
        last = list(r.channels.values())[-1]
        return float(np.nansum(np.array(last.through_time.variance, float)))

    chosen = sorted(recordings, key=spread, reverse=True)[:MOST]
    return [r for r in recordings if any(r is one for one in chosen)]
