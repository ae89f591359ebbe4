"""Share of each place in the gap."""

from typing import TYPE_CHECKING

from tp_jax.report import layout, style, words
from tp_jax.report.figures import bars
from tp_jax.report.formatting import percent
from tp_jax.results.diagnosis import DiagnosisRecord, Found, Location

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8


def shown(diagnosis: DiagnosisRecord) -> list[Location]:
    """Places with a share, largest first as given."""
    return [place for place in diagnosis.where if place.share is not None][:MOST]


def draw(found: Found, width: float = style.WIDE) -> "Figure | None":
    """One bar for each place.

    Returns:
        None if no place has a share.
    """
    places = shown(DiagnosisRecord.read(found))
    if not places:
        return None
    shares = [place.share or 0.0 for place in places]
    figure = style.new_figure(width, 0.8 + 0.42 * len(places))
    axes = figure.subplots()
    style.dress(axes, grid=None)
    colours = [style.BEFORE] + [style.BAND] * (len(places) - 1)
    axes.barh(range(len(places)), shares, height=0.62, color=colours, lw=0.0)
    right = bars.numbers(axes, range(len(places)), shares, [percent(share) for share in shares])
    names = [place.location for place in places]
    if width >= style.BESIDE:
        names = [words.location(name).removeprefix("the ") for name in names]
    left = bars.names(axes, names, width)
    axes.set_xlim(0.0, max(*shares, 0.05))
    axes.set_xticks([])
    layout.label_below(axes, "share of the gap", away=layout.SPACING.pad, at=0.0)
    layout.place(figure, left=left, right=right, below=bars.BELOW)
    return figure
