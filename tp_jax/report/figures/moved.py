"""Shifts of the parameters by the causes, each in its own standard errors."""

import math
from typing import TYPE_CHECKING

from tp_jax.report import layout, style
from tp_jax.report.figures import bars
from tp_jax.report.formatting import number
from tp_jax.results.diagnosis import DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTABLE = 2.0  # standard errors; the scale is straight up to here and logarithmic beyond
_STRAIGHT = 0.5  # length of the straight part on either side, in decades of the other


def shown(diagnosis: DiagnosisRecord) -> list[tuple[str, float]]:
    """Parameter and shift in standard errors, the largest first."""
    found = [(name, moved.in_standard_errors) for name, moved in diagnosis.absorbed.items()]
    known = [(name, shift) for name, shift in found if shift is not None]
    return sorted(known, key=lambda row: -abs(row[1]))


def draw(found: Found, width: float = style.WIDE) -> "Figure | None":
    """A bar for each parameter.

    Returns:
        None if nothing is known of any.
    """
    rows = shown(DiagnosisRecord.read(found))
    if not rows:
        return None
    figure = style.new_figure(width, 0.9 + 0.3 * len(rows))
    axes = figure.subplots()
    style.dress(axes, grid="x")
    shifts = [shift for _, shift in rows]
    axes.axvspan(-_NOTABLE, _NOTABLE, color=style.BAND, alpha=0.25, lw=0.0)
    axes.barh(range(len(rows)), shifts, height=0.62, color=style.BEFORE, lw=0.0)
    axes.axvline(0.0, color=style.INK, lw=0.8)
    texts = [number(shift, 2) for shift in shifts]
    room = bars.numbers(axes, range(len(rows)), shifts, texts, style.SMALL)
    left = bars.names(axes, [name for name, _ in rows], width)
    axes.set_xscale("symlog", linthresh=_NOTABLE, linscale=_STRAIGHT)
    length = width - left - 2.0 * layout.SPACING.edge
    axes.set_xlim(*_ends(shifts, room / length))
    axes.set_xticks([])
    axes.minorticks_off()
    told = "moved by, in standard errors; grey: less than two"
    if width < style.BESIDE:
        told = "moved by [standard errors]; grey: below 2"
    at = 0.5 if layout.width_of([told]) < length else 1.0
    layout.label_below(axes, told, away=layout.SPACING.pad, at=at)
    layout.place(figure, left=left, right=0.0, below=bars.BELOW)
    return figure


def _ends(shifts: list[float], room: float) -> tuple[float, float]:
    """Ends of the axis; `room` is the share of its length that a number takes at a bar's end."""
    far = math.log10(max(*map(abs, shifts), _NOTABLE) / _NOTABLE)
    sides = min(shifts) < 0.0, max(shifts) > 0.0
    length = 2.0 * _STRAIGHT + sum(sides) * far
    more = min(length * room / (1.0 - min(sum(sides) * room, 0.8)), 9.0)
    end = _NOTABLE * 10.0 ** (far + more)
    return -end if sides[0] else -_NOTABLE, end if sides[1] else _NOTABLE
