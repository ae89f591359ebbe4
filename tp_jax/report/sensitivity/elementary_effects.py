"""Morris' picture: size of a parameter's effect, and how far it depends on the others."""

from typing import TYPE_CHECKING

from tp_jax.report import style
from tp_jax.report.sensitivity.words import CHANNELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tp_jax.results.sensitivity import SensitivityRecord

LEAST = 1e-3  # mrad; what has less effect stands at the corner


def draw(analysis: "SensitivityRecord") -> "Figure | None":
    """mu* against sigma, a point for each parameter: the recording where it does most."""
    recordings = analysis.morris.recordings
    if not recordings:
        return None
    columns = list(recordings[0].channels)
    noise = analysis.quality.noise_floor
    figure = style.new_figure(style.WIDE, 4.2, fitted=True)
    grid = figure.subplots(1, len(columns), squeeze=False)[0]
    for c, axes in zip(columns, grid, strict=True):
        style.dress(axes)
        axes.grid(axis="x", color=style.BAND, lw=0.6, alpha=0.35)
        points = {}
        tables = [r.channels[c] for r in recordings]
        for n in tables[0].mu_star:
            most = max(tables, key=lambda table, n=n: table.mu_star[n] or 0.0)
            sizes = most.mu_star[n] or 0.0, most.sigma[n] or 0.0
            points[n] = tuple(max(1e3 * size, LEAST) for size in sizes)
        low, high = LEAST, 3.0 * max(max(p) for p in points.values())
        axes.plot([low, high], [low, high], color=style.BAND, lw=0.8, ls=(0, (3, 2)))
        axes.axvline(1e3 * noise[c], color=style.INK, lw=1.0, ls=(0, (2, 2)))
        for i, (n, (x, y)) in enumerate(sorted(points.items(), key=lambda p: p[1])):
            axes.plot(x, y, marker="o", ms=5, color=style.AFTER, mew=0.0, clip_on=False)
            text = f"{n}: no effect" if x <= LEAST else n
            axes.annotate(
                text,
                (x, y),
                (-5, 5) if i % 2 else (6, -9),
                textcoords="offset points",
                ha="right" if i % 2 else "left",
                fontsize=style.FONT_SIZE,
                color=style.INK,
            )
        axes.set(xscale="log", yscale="log", xlim=(0.7 * low, high), ylim=(0.7 * low, high))
        axes.set_xlabel("mean size of its effect, μ* [mrad]; dashed: the noise")
        style.title(axes, CHANNELS[c])
    grid[0].set_ylabel("spread of its effect, σ [mrad]")
    return figure
