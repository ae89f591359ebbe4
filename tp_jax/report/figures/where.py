"""Where the gap lies: the share of each place."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import layout, reading, style, words
from tp_jax.report.figures import bars
from tp_jax.report.formatting import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8


def shown(diagnosis: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Places with a share, largest first as given."""
    places = reading.rows(diagnosis, "where")
    return [
        place
        for place in places
        if reading.text(place, "location") and reading.value(place, "share") is not None
    ][:MOST]


def draw(diagnosis: Mapping[str, Any], width: float = style.WIDE) -> "Figure | None":
    """One bar for each place.

    Returns:
        None if no place has a share.
    """
    places = shown(diagnosis)
    if not places:
        return None
    shares = [reading.value(place, "share") or 0.0 for place in places]
    figure = style.new_figure(width, 0.8 + 0.42 * len(places))
    axes = figure.subplots()
    style.dress(axes, grid=None)
    colours = [style.BEFORE] + [style.BAND] * (len(places) - 1)
    axes.barh(range(len(places)), shares, height=0.62, color=colours, lw=0.0)
    right = bars.numbers(axes, range(len(places)), shares, [percent(share) for share in shares])
    names = [reading.text(place, "location") for place in places]
    if width >= style.BESIDE:
        names = [words.location(name).removeprefix("the ") for name in names]
    left = bars.names(axes, names, width)
    axes.set_xlim(0.0, max(*shares, 0.05))
    axes.set_xticks([])
    layout.label_below(axes, "share of the gap", away=layout.SPACING.pad, at=0.0)
    layout.place(figure, left=left, right=right, below=bars.BELOW)
    return figure
