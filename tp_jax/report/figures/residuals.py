"""Windowed residuals over time, in units of the noise, before and after."""

from typing import TYPE_CHECKING

from tp_jax.report import style
from tp_jax.report.figures.curves import curves_of, drawable, largest, rms
from tp_jax.report.figures.rows import over_time
from tp_jax.report.formatting import number
from tp_jax.results.diagnosis import CHANNELS, DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(found: Found, index: int = 0, width: float = style.WIDE) -> "Figure | None":
    """One row for each channel; the band holds 95 % of pure noise.

    Args:
        index: which of the recordings that have residuals.
        width: in inches.

    Returns:
        None if there is no such recording.
    """
    entries = drawable(DiagnosisRecord.read(found).residuals)
    if index >= len(entries):
        return None
    channels = curves_of(entries[index])
    figure = style.new_figure(width, 0.6 + (1.9 if width >= style.WIDE else 2.0) * len(channels))
    rows = figure.subplots(len(channels), 1, sharex=True, squeeze=False)[:, 0]
    for curve, axes in zip(channels, rows, strict=True):
        style.dress(axes)
        axes.axhspan(-1.96, 1.96, color=style.BAND, alpha=0.25, lw=0.0, label="noise (95 %)")
        if curve.before is not None:
            label = "model" if curve.after is None else "before"
            axes.plot(curve.t, curve.before, color=style.BEFORE, lw=0.9, label=label)
        if curve.after is not None:
            axes.plot(curve.t, curve.after, color=style.AFTER, lw=0.9, label="after")
        end = max(1.05 * largest(curve.before, curve.after), 3.0)
        axes.set_ylim(-end, end)
        axes.margins(x=0.0)
    labels = [f"{CHANNELS[curve.channel]} [noise]" for curve in channels]
    over_time(figure, rows, labels, style.legend(figure, rows[0]))
    return figure


def described(diagnosis: DiagnosisRecord, index: int = 0) -> str:
    """The rms of each channel in units of the noise."""
    said = []
    for curve in curves_of(drawable(diagnosis.residuals)[index]):
        name = CHANNELS[curve.channel]
        before, after = rms(curve.before), rms(curve.after)
        if before is not None and after is not None:
            said.append(f"{name} {number(before)} before and {number(after)} after")
        elif before is not None or after is not None:
            said.append(f"{name} {number(after if before is None else before)}")
    return f"rms in units of the noise: {'; '.join(said)}"
