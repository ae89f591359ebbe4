"""The curve of a learned cause, above the histogram of what the recordings visited."""

from typing import TYPE_CHECKING

from tp_jax.report import layout, style
from tp_jax.report.formatting import bounds
from tp_jax.results.diagnosis import Cause, Curve, DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HISTOGRAM = 0.3  # of the curve's height


def shown(diagnosis: DiagnosisRecord) -> list[tuple[Cause, Curve]]:
    """The causes that have a curve."""
    found = [(cause, cause.curve) for cause in diagnosis.accepted]
    return [(cause, curve) for cause, curve in found if curve and 0 < len(curve.x) == len(curve.y)]


def draw(found: Found, index: int = 0, width: float = style.WIDE) -> "Figure | None":
    """The curve with its band; below, how often each value occurred.

    Args:
        index: which of the causes that have a curve.
        width: in inches.

    Returns:
        None if there is no such cause.
    """
    causes = shown(DiagnosisRecord.read(found))
    if index >= len(causes):
        return None
    curve = causes[index][1]
    figure = style.new_figure(width, 3.2)
    rows = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, _HISTOGRAM])
    for axes in rows:
        style.dress(axes)
    band = [ends for each in curve.ci95 if (ends := bounds(each)) is not None]
    if len(band) == len(curve.x):
        low, high = zip(*band, strict=True)
        rows[0].fill_between(curve.x, low, high, color=style.BAND, alpha=0.35, lw=0.0, label="95 %")
    rows[0].plot(curve.x, curve.y, color=style.AFTER, lw=1.4, label="learned")
    rows[0].margins(x=0.0)
    edges, share = curve.visited.edges, curve.visited.share
    if len(edges) == len(share) + 1:
        rows[1].stairs(share, edges, fill=True, color=style.BAND)
    rows[1].set_yticks([])
    left = layout.numbers(rows[:1]) + layout.SPACING.line
    layout.label_left(rows[0], _with_unit("change", curve.y_unit), left - layout.SPACING.line)
    layout.label_below(rows[1], _with_unit(curve.argument, curve.unit))
    layout.place(figure, left=left + layout.SPACING.line, above=style.legend(figure, rows[0]))
    return figure


def _with_unit(text: str, unit: str) -> str:
    return text if unit in ("", "1") else f"{text} [{unit}]"
