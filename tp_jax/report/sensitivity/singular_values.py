"""Structural identifiability: singular values at random points, and what is null at all of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tp_jax.report import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import NullDirection, SensitivityRecord

LEAST = 1e-17


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """Left the singular values of each point, right the directions in which nothing is seen."""
    s = analysis.structural
    values = np.array(s.singular_values, float)
    if not values.size:
        return None
    names = s.parameters
    directions = analysis.null_directions
    figure = style.new_figure(style.WIDE, max(3.6, 1.2 + 0.28 * len(names)), fitted=True)
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.1))
    style.dress(left)
    ratio = np.maximum(values / values[:, :1], LEAST)
    places = np.arange(1, len(names) + 1)
    for row in ratio:
        left.plot(places, row, color=style.AFTER, lw=0.8, marker="o", ms=3.0, mew=0.0, alpha=0.6)
    rank = s.rank
    if rank < len(names):
        left.axvspan(rank + 0.5, len(names) + 0.5, color=style.BAND, alpha=0.25, lw=0.0)
        left.text(
            len(names) + 0.4,
            2.0,
            "nothing but rounding",
            ha="right",
            va="bottom",
            fontsize=style.FONT_SIZE,
            color=style.INK,
        )
    left.set(yscale="log", ylim=(LEAST, 30.0), xlim=(0.5, len(names) + 0.5))
    left.set_xticks(places)
    left.set_xlabel("singular value, largest first")
    left.set_ylabel("size, relative to the largest")
    style.title(left, f"{s.points} random points: rank {rank} of {len(names)}")
    _directions(right, directions, names)
    return figure


def _directions(axes: Any, directions: "Sequence[NullDirection]", names: Sequence[str]) -> None:
    style.dress(axes, grid="x")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    style.title(axes, "what can change unseen" if directions else "nothing can change unseen")
    for x, d in enumerate(directions):
        colour = style.AFTER if d.kind == "structural" else style.BEFORE
        for n, c in d.parameters.items():
            if n not in names:
                continue
            y = names.index(n)
            axes.plot(x, y, marker="o", ms=4.0 + 9.0 * abs(c), color=colour, mew=0.0)
            axes.annotate(
                f"{c:+.2g}".replace("-", "−"),
                (x, y),
                (11, 0),
                textcoords="offset points",
                va="center",
                fontsize=style.FONT_SIZE - 1.5,
                color=style.INK,
            )
    labels = [f"{d.kind}\n{d.removed_by or 'stays unknown'}" for d in directions]
    axes.set_xlim(-0.5, max(len(directions), 1) - 0.3)
    axes.set_xticks(range(len(directions)), labels)
