"""How far each parameter moved when the causes were added, in its own standard errors."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tp_jax.report import reading, style
from tp_jax.report.formatting import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTABLE = 2.0  # standard errors; the scale is straight up to here and logarithmic beyond


def shown(diagnosis: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Parameter and shift in standard errors, the largest first."""
    absorbed = reading.table(diagnosis, "absorbed")
    found = [(name, reading.value(absorbed, name, "in_standard_errors")) for name in absorbed]
    known = [(name, shift) for name, shift in found if shift is not None]
    return sorted(known, key=lambda row: -abs(row[1]))


def draw(diagnosis: Mapping[str, Any], width: float = style.WIDE) -> "Figure | None":
    """A bar for each parameter.

    Returns:
        None if nothing is known of any.
    """
    rows = shown(diagnosis)
    if not rows:
        return None
    figure = style.new_figure(width, 0.9 + 0.3 * len(rows))
    axes = figure.subplots()
    style.dress(axes, grid="x")
    shifts = [shift for _, shift in rows]
    axes.axvspan(-_NOTABLE, _NOTABLE, color=style.BAND, alpha=0.25, lw=0.0)
    axes.barh(range(len(rows)), shifts, height=0.62, color=style.BEFORE, lw=0.0)
    axes.axvline(0.0, color=style.INK, lw=0.8)
    for y, shift in enumerate(shifts):
        right = shift >= 0.0
        axes.annotate(
            number(shift, 2), (shift, y), (4 if right else -4, 0), textcoords="offset points",
            ha="left" if right else "right", va="center", fontsize=style.FONT_SIZE - 1.5,
            color=style.INK,
        )  # fmt: skip
    axes.set_xscale("symlog", linthresh=_NOTABLE, linscale=0.5)
    end = 6.0 * max(*map(abs, shifts), _NOTABLE)  # room for the numbers
    axes.set_xlim(-end if min(shifts) < 0.0 else -_NOTABLE, end if max(shifts) > 0.0 else _NOTABLE)
    axes.set_xticks([])
    axes.minorticks_off()
    axes.set_yticks(range(len(rows)), [name for name, _ in rows])
    axes.invert_yaxis()
    axes.set_xlabel("moved by, in standard errors; grey: less than two")
    return figure
