"""Unknowns that the starts found: each, from where it began to where it ended."""

from typing import TYPE_CHECKING

import numpy as np

from tp_jax.estimation.identification import Identification
from tp_jax.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST = 1e-6  # of the best's: a friction that is not there is shown at the edge


def unknowns(result: Identification) -> "Figure":
    """Each unknown over its value at the best: drawn points, and ends of the starts.

    Those of either sign (phases and zeros) and those that are zero at the best have no such ratio
    and are left out.
    """
    names = np.array([u.name for u in result.fit.unknowns])
    came = [t for t in result.trials if np.isfinite(t.end.cost)]  # the others came to nothing
    ends = np.array([t.end.x for t in came])
    costs = np.array([t.end.cost for t in came])
    best = ends[int(np.argmin(costs))]
    drawn = np.array([t.start.point for t in result.trials if t.start.point is not None])
    drawn = drawn.reshape(-1, names.size)
    reached = costs - costs.min() <= 1.0
    shown = (best > 0.0) & (ends >= 0.0).all(axis=0) & (drawn >= 0.0).all(axis=0)
    rows = np.arange(int(shown.sum()))

    figure = style.new_figure(style.BESIDE, 0.9 + 0.28 * rows.size, fitted=True)
    axes = figure.subplots()
    style.dress(axes, grid="x")
    for values, color, marker, size, label in (
        (drawn, style.BAND, "|", 7.0, "drawn"),
        (ends[~reached], style.BEFORE, "s", 4.0, "ended elsewhere"),
        (ends[reached], style.AFTER, "o", 4.0, "reached the best"),
    ):
        if not len(values):
            continue
        ratio = np.maximum(values[:, shown] / best[shown], LEAST)
        axes.plot(
            ratio.ravel(),
            np.tile(rows, len(values)),
            color=color,
            marker=marker,
            ls="",
            ms=size,
            mew=1.0 if marker == "|" else 0.0,
            label=label,
        )
    axes.axvline(1.0, color=style.MUTED, lw=0.8, ls="--")
    axes.set_xscale("log")
    axes.set_yticks(rows, names[shown])
    axes.invert_yaxis()
    axes.set_xlabel("value over that of the best")
    style.legend(figure, axes)
    return figure
