"""The gap over angle and velocity: in which part of its motion each body leaves the model."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tp_jax.report import layout, style
from tp_jax.report.figures.curves import curves_of, dense, drawable
from tp_jax.results.diagnosis import CHANNELS, DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CELLS = 14  # along each axis
_BAR = 0.16  # inches: width of the scale
_LEAST_SCALE = 3.0  # standard deviations of the noise; a model that is complete stays dark


class Points(NamedTuple):
    """Places of one channel, (n,) each, and how far the model missed it in units of the noise."""

    channel: str
    angle: np.ndarray
    velocity: np.ndarray
    before: np.ndarray | None
    after: np.ndarray | None


def points(diagnosis: DiagnosisRecord) -> list[Points]:
    """The channels that can be mapped, over all held-out recordings.

    Angle and velocity are those measured, from `curves`, whose points are those of `residuals`. A
    channel is left out where they lie too far apart for a velocity.
    """
    motions = {}
    for entry in drawable(diagnosis.curves):
        for curve in curves_of(entry):
            if curve.measured is not None and dense(curve):
                motions[entry.recording, curve.channel] = curve
    found: dict[str, list[Points]] = {}
    for entry in drawable(diagnosis.residuals):
        for missed in curves_of(entry):
            motion = motions.get((entry.recording, missed.channel))
            if motion is None or not np.array_equal(motion.t, missed.t):
                continue
            velocity = np.gradient(motion.measured, motion.t)
            one = Points(missed.channel, motion.measured, velocity, missed.before, missed.after)
            found.setdefault(missed.channel, []).append(one)
    return [_joined(parts) for parts in found.values()]


def draw(found: Found, width: float = style.WIDE) -> "Figure | None":
    """A row for each channel; before and after side by side, on one scale.

    Returns:
        None if no channel can be mapped.
    """
    rows = points(DiagnosisRecord.read(found))
    states = [s for s in ("before", "after") if any(getattr(row, s) is not None for row in rows)]
    if not rows or not states:
        return None
    figure = style.new_figure(width, 0.5 + (3.0 if width >= style.WIDE else 2.1) * len(rows))
    grid = figure.subplots(len(rows), len(states), sharey="row", squeeze=False)
    drawn = [_row(row, states, line, width) for row, line in zip(rows, grid, strict=True)]
    tops = [image.norm.vmax for image in drawn if image is not None]
    bar = layout.width_of([f"{top:.1f}" for top in tops]) + _BAR + 3.0 * layout.SPACING.pad
    title = layout.SPACING.line if len(states) > 1 else 0.0
    spaces = dict(
        right=bar + layout.SPACING.line,
        above=title,
        beside=2.0 * layout.SPACING.over,
        between=layout.SPACING.ticks + layout.SPACING.line + layout.SPACING.between + title,
    )
    layout.place(figure, left=layout.SPACING.line, **spaces)  # the height decides on the ticks
    away = layout.numbers(grid[:, 0])
    for row, line in zip(rows, grid, strict=True):
        layout.label_left(line[0], f"velocity of {CHANNELS[row.channel]} [rad/s]", away)
    layout.place(figure, left=away + layout.SPACING.line, **spaces)
    for image, line in zip(drawn, grid, strict=True):
        if image is not None:
            _bar(figure, image, line[-1], bar)
    return figure


def _row(row: Points, states: list[str], line: Any, width: float) -> Any:
    """The maps of one channel; returns the last one's image, None where there is none."""
    edges = _edges(row.angle), _edges(row.velocity)
    maps = {s: _binned(row, s, edges) for s in states}
    sizes = [np.nanmax(m) for m in maps.values() if m is not None and np.isfinite(m).any()]
    top = max([_LEAST_SCALE, *sizes])
    image = None
    for state, axes in zip(states, line, strict=True):
        style.dress(axes, grid=None)
        cells = maps[state]
        if cells is None:
            continue
        image = axes.imshow(
            np.ma.masked_invalid(cells.T),
            origin="lower",
            aspect="auto",
            interpolation="none",
            cmap=style.SCALE,
            vmin=0.0,
            vmax=top,
            extent=(*edges[0][[0, -1]], *edges[1][[0, -1]]),
        )
        axes.locator_params(nbins=6)
        if width < style.WIDE:  # numbers side by side take more of it than those above each other
            axes.locator_params(axis="x", nbins=3, steps=[1, 2, 5, 10])
            axes.tick_params(axis="x", labelsize=style.SMALL)
        layout.label_below(axes, f"{CHANNELS[row.channel]} [rad]")
        if len(states) > 1:
            style.title(axes, state)
    return image


def described(diagnosis: DiagnosisRecord) -> str:
    """Says where the largest miss of the model before lies."""
    said = []
    for row in points(diagnosis):
        edges = _edges(row.angle), _edges(row.velocity)
        cells = _binned(row, "before", edges)
        if cells is None or not np.isfinite(cells).any():
            continue
        i, j = np.unravel_index(np.nanargmax(cells), cells.shape)
        angle, velocity = (0.5 * (e[n] + e[n + 1]) for e, n in zip(edges, (i, j), strict=True))
        said.append(
            f"{CHANNELS[row.channel]} near {_signed(angle)} rad and "
            f"{_signed(velocity)} rad/s ({np.nanmax(cells):.2g} times the noise)"
        )
    return "; ".join(said)


def _signed(value: float) -> str:
    return f"{value:.2g}".replace("-", "−")


def _joined(parts: list[Points]) -> Points:
    """One channel over all its recordings."""
    columns = []
    for name in ("angle", "velocity", "before", "after"):
        given = [getattr(p, name) for p in parts]
        columns.append(None if any(y is None for y in given) else np.concatenate(given))
    angle = columns[0]
    if np.ptp(angle) > 2.0 * np.pi:  # it winds on: what counts is the angle within a turn
        columns[0] = np.mod(angle + np.pi, 2.0 * np.pi) - np.pi
    return Points(parts[0].channel, *columns)


def _edges(values: np.ndarray) -> np.ndarray:
    inside = values[np.isfinite(values)]
    low, high = float(inside.min()), float(inside.max())
    return np.linspace(low, high if high > low else low + 1.0, CELLS + 1)


def _binned(row: Points, state: str, edges: tuple[np.ndarray, np.ndarray]) -> np.ndarray | None:
    """(CELLS, CELLS) rms of the residuals in each cell; NaN where the motion never was."""
    missed = getattr(row, state)
    if missed is None:
        return None
    whole = np.isfinite(row.angle) & np.isfinite(row.velocity) & np.isfinite(missed)
    place = row.angle[whole], row.velocity[whole]
    count = np.histogram2d(*place, bins=edges)[0]
    total = np.histogram2d(*place, bins=edges, weights=missed[whole] ** 2)[0]
    return np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def _bar(figure: "Figure", image: Any, last: "Axes", away: float) -> None:
    """The scale, right of the last map of a row; its label stands `away` inches from that."""
    width = figure.get_figwidth()
    place = last.get_position()
    left = place.x1 + layout.SPACING.pad / width
    axes = figure.add_axes((left, place.y0, _BAR / width, place.height))
    bar = figure.colorbar(image, cax=axes)
    bar.outline.set_visible(False)
    axes.tick_params(labelsize=style.FONT_SIZE, labelcolor=style.INK, length=0.0, pad=3.0)
    axes.yaxis.label.set(size=style.FONT_SIZE, color=style.INK, verticalalignment="top")
    layout.label_left(axes, "residual [noise]", layout.SPACING.pad - away)
