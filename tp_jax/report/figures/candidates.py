"""The most probable candidates: how far each alone was predicted to shrink the gap, and did."""

from typing import TYPE_CHECKING

from tp_jax.report import layout, style
from tp_jax.report.figures import bars
from tp_jax.report.formatting import percent
from tp_jax.results.diagnosis import Candidate, DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 10
_LEAST = -0.25  # longer bars to the left end here, their numbers stand beside them


def shown(diagnosis: DiagnosisRecord) -> list[Candidate]:
    """The candidates that the figure shows: the first ten that have a number."""
    return [row for row in diagnosis.applicable if _numbers(row)][:MOST]


def draw(found: Found, width: float = style.WIDE) -> "Figure | None":
    """Two bars for each candidate, accepted causes in bold.

    Returns:
        None if no candidate has a number.
    """
    diagnosis = DiagnosisRecord.read(found)
    rows = shown(diagnosis)
    if not rows:
        return None
    figure = style.new_figure(width, 1.0 + 0.42 * len(rows))
    axes = figure.subplots()
    style.dress(axes, grid="x")
    right = layout.width_of(["100 %"])  # half of the last tick's stands over the end
    for key, label, offset, colour in (
        ("predicted_shrink", "predicted", -0.19, style.BAND),
        ("realised_shrink", "realised after refitting", 0.19, style.AFTER),
    ):
        # one bar alone stands in the middle
        known = [
            (y + offset * (len(_numbers(row)) > 1), size)
            for y, row in enumerate(rows)
            if (size := getattr(row, key)) is not None
        ]
        if known:
            places, sizes = zip(*known, strict=True)
            drawn = [min(max(x, _LEAST), 1.0) for x in sizes]
            axes.barh(places, drawn, height=0.36, color=colour, label=label, lw=0.0)
            ends = [max(end, 0.0) for end in drawn]
            texts = [percent(x) for x in sizes]
            right = max(right, bars.numbers(axes, places, ends, texts, style.SMALL))
    names = [row.effect for row in rows]
    left = bars.names(axes, names, width, [name in diagnosis.causes for name in names])
    lowest = min(0.0, *(x for row in rows for x in _numbers(row)))
    axes.set_xlim(max(lowest, _LEAST), 1.0)
    axes.set_xticks([0.0, 0.5, 1.0], ["0", "50 %", "100 %"])
    if lowest < 0.0:
        axes.axvline(0.0, color=style.INK, lw=0.8)
    layout.label_below(axes, "removable gap that is gone")
    layout.place(figure, left=left, right=right, above=style.legend(figure, axes))
    return figure


def _numbers(row: Candidate) -> list[float]:
    """Returns what is known of its two bars."""
    return [x for x in (row.predicted_shrink, row.realised_shrink) if x is not None]
