"""Shares of intervals that held the truth, against what they promise."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scripts._coverage.tally import TARGET
from tp_jax.report import style


def draw(found: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """A dot with its interval for each parameter; the band is what is asked for."""
    figure = style.new_figure(style.BESIDE, 1.2 + 0.34 * len(found))
    axes = figure.subplots()
    style.dress(axes, grid=None)
    axes.axvspan(*TARGET, color=style.BAND, alpha=0.25, lw=0.0)
    axes.axvline(0.95, color=style.INK, lw=1.0, ls=(0, (2, 2)))
    for y, row in enumerate(found.values()):
        low, high = row["ci95"]
        axes.plot([low, high], [y, y], color=style.AFTER, lw=2.0)
        axes.plot(row["share"], y, marker="o", ms=6.0, mew=0.0, color=style.AFTER)
    axes.set_yticks(range(len(found)), [f"{n} ({r['by']})" for n, r in found.items()])
    axes.invert_yaxis()
    count = max((row["of"] for row in found.values()), default=0)
    axes.set_xlabel(f"share of 95 % intervals that hold the truth, {count} rigs")
    style.save(figure, path)
