"""Where the gap lies: the share of each place."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import reading, style, words
from tp_jax.report.formatting import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8
_LONGEST = 32


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
    for y, share in enumerate(shares):
        axes.annotate(
            percent(share), (share, y), (5, 0), textcoords="offset points", va="center",
            fontsize=style.FONT_SIZE, color=style.INK,
        )  # fmt: skip
    names = [reading.text(place, "location") for place in places]
    if width >= style.BESIDE:
        names = [words.location(name).removeprefix("the ") for name in names]
    names = [name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…" for name in names]
    axes.set_yticks(range(len(places)), names)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.18 * max(max(shares), 0.05))
    axes.set_xticks([])
    axes.set_xlabel("share of the gap", loc="left")
    return figure
