"""The error on held-out data before and after, against the noise."""

from typing import TYPE_CHECKING

from tp_jax.report import layout, style
from tp_jax.report.figures import bars
from tp_jax.report.formatting import angles
from tp_jax.results.diagnosis import DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KINDS = {"free_run": "free run", "windowed": "in windows"}


def shown(diagnosis: DiagnosisRecord) -> list[tuple[str, str, float]]:
    """Kind of error, before or after, and its size [rad], as far as they are known."""
    found = [
        (kind, state, getattr(getattr(diagnosis.gap, state), kind))
        for kind in _KINDS
        for state in ("before", "after")
    ]
    return [(kind, state, size) for kind, state, size in found if size is not None]


def draw(found: Found, width: float = style.WIDE) -> "Figure | None":
    """A bar for each error, with the noise floor as a line.

    Returns:
        None if no error is known.
    """
    diagnosis = DiagnosisRecord.read(found)
    rows = shown(diagnosis)
    if not rows:
        return None
    sizes = [size for *_, size in rows]
    figure = style.new_figure(width, 0.9 + 0.38 * len(rows))
    axes = figure.subplots()
    style.dress(axes, grid=None)
    colours = {"before": style.BEFORE, "after": style.AFTER}
    axes.barh(range(len(rows)), sizes, height=0.66, color=[colours[state] for _, state, _ in rows])
    right = bars.numbers(axes, range(len(rows)), sizes, angles(sizes))
    floor = diagnosis.floor
    if floor is not None:
        axes.axvline(floor, color=style.INK, lw=1.0, ls=(0, (2, 2)))
    left = bars.names(axes, [f"{_KINDS[kind]}, {state}" for kind, state, _ in rows], width)
    axes.set_xlim(0.0, 1.02 * max(*sizes, floor or 0.0, 1e-12))
    axes.set_xticks([])
    told = "error (rms)" if floor is None else "error (rms); dashed: the noise"
    layout.label_below(axes, told, away=layout.SPACING.pad)
    layout.place(figure, left=left, right=right, below=bars.BELOW)
    return figure
