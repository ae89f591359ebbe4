"""The curve of a learned cause, above the histogram of what the recordings visited."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import layout, reading, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HISTOGRAM = 0.3  # of the curve's height


def shown(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The causes that have a curve."""
    return [cause for cause in reading.causes(diagnosis) if _numbers(cause, "x")]


def draw(
    diagnosis: Mapping[str, Any], index: int = 0, width: float = style.WIDE
) -> "Figure | None":
    """The curve with its band; below, how often each value occurred.

    Args:
        index: which of the causes that have a curve.
        width: in inches.

    Returns:
        None if there is no such cause.
    """
    found = shown(diagnosis)
    if index >= len(found):
        return None
    curve = reading.table(found[index], "curve")
    x, y = _numbers(found[index], "x"), _numbers(found[index], "y")
    figure = style.new_figure(width, 3.2)
    rows = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, _HISTOGRAM])
    for axes in rows:
        style.dress(axes)
    band = curve.get("ci95") or []
    if len(band) == len(x):
        low, high = zip(*band, strict=True)
        rows[0].fill_between(x, low, high, color=style.BAND, alpha=0.35, lw=0.0, label="95 %")
    rows[0].plot(x, y, color=style.AFTER, lw=1.4, label="learned")
    rows[0].margins(x=0.0)
    visited = reading.table(curve, "visited")
    edges, share = visited.get("edges") or [], visited.get("share") or []
    if len(edges) == len(share) + 1:
        rows[1].stairs(share, edges, fill=True, color=style.BAND)
    rows[1].set_yticks([])
    unit, of = reading.text(curve, "unit"), reading.text(curve, "y_unit")
    left = layout.numbers(rows[:1]) + layout.SPACING.line
    layout.label_left(rows[0], _with_unit("change", of), left - layout.SPACING.line)
    layout.label_below(rows[1], _with_unit(reading.text(curve, "argument"), unit))
    layout.place(figure, left=left + layout.SPACING.line, above=style.legend(figure, rows[0]))
    return figure


def _with_unit(text: str, unit: str) -> str:
    return text if unit in ("", "1") else f"{text} [{unit}]"


def _numbers(cause: Mapping[str, Any], key: str) -> list[float]:
    found = reading.table(cause, "curve").get(key)
    return list(found) if isinstance(found, list) else []
