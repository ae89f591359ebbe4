"""Free runs over held-out recordings: measured, and the model before and after."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tp_jax.report import style
from tp_jax.report.figures.curves import Curve, curves_of, dense, drawable, error, largest, rms
from tp_jax.report.figures.rows import over_time
from tp_jax.report.formatting import angle, angle_unit
from tp_jax.results.diagnosis import CHANNELS, DiagnosisRecord, Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CLOSE_POINTS = 90
_BAND = 1.96  # standard deviations that hold 95 % of normal noise


def draw(found: Found, index: int = 0, width: float = style.WIDE) -> "Figure | None":
    """For each channel the angle above and the error below.

    Args:
        index: which of the recordings that have curves.
        width: in inches.

    Returns:
        None if there is no such recording.
    """
    diagnosis = DiagnosisRecord.read(found)
    entries = drawable(diagnosis.curves)
    if index >= len(entries):
        return None
    channels = curves_of(entries[index])
    figure = style.new_figure(width, 0.5 + (3.1 if width >= style.WIDE else 2.9) * len(channels))
    rows = figure.subplots(
        2 * len(channels),
        1,
        sharex=True,
        squeeze=False,
        height_ratios=[1.7, 1.0] * len(channels),
    )[:, 0]
    for curve, above, below in zip(channels, rows[::2], rows[1::2], strict=True):
        _angles(above, curve)
        _errors(below, curve, diagnosis.noise_floor.get(curve.channel))
    labels = [label for curve in channels for label in _labels(curve)]
    over_time(figure, rows, labels, style.legend(figure, rows[0], rows[1]))
    return figure


def close_up(found: Found, width: float = style.BESIDE) -> "Figure | None":
    """The stretch of a free run in which the model before misses most, in one channel."""
    diagnosis = DiagnosisRecord.read(found)
    curve = worst(diagnosis)
    if curve is None:
        return None
    figure = style.new_figure(width, 3.5 if width >= style.BESIDE else 2.65)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.25])
    _angles(above, curve)
    _errors(below, curve, diagnosis.noise_floor.get(curve.channel))
    over_time(figure, [above, below], _labels(curve), style.legend(figure, above, below))
    return figure


def worst(diagnosis: DiagnosisRecord) -> Curve | None:
    """Finds what `close_up` shows: of the first recording, the channel and the stretch missed most.

    A curve of too few points is shown whole: no stretch of it says more than the rest.
    """
    found = [
        curve
        for entry in drawable(diagnosis.curves)[:1]
        for curve in curves_of(entry)
        if error(curve, "before") is not None
    ]
    if not found:
        return None
    curve = max(found, key=lambda curve: rms(error(curve, "before")) or 0.0)
    miss = error(curve, "before")
    if miss is None or curve.t.size <= _CLOSE_POINTS or not dense(curve):
        return curve
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(miss) ** 2)])
    begin = int(np.argmax(total[_CLOSE_POINTS:] - total[:-_CLOSE_POINTS]))
    return curve.part(slice(begin, begin + _CLOSE_POINTS))


def _angles(axes: "Axes", curve: Curve) -> None:
    style.dress(axes)
    axes.margins(x=0.0)
    joined = dense(curve)
    looks: dict[str, dict[str, Any]] = {
        "measured": dict(color=style.BAND, lw=3.6, alpha=0.6, solid_capstyle="round"),
        "before": dict(color=style.BEFORE, lw=1.2, ls=(0, (5, 1.6))),
        "after": dict(color=style.AFTER, lw=1.2),
    }
    for name, look in looks.items():
        y = getattr(curve, name)
        if y is None:
            continue
        label = "model" if name == "before" and curve.after is None else name
        if joined:
            axes.plot(curve.t, y, label=label, **look)
        else:
            size = 3.0 if name == "measured" else 1.4
            style.dots(axes, curve.t, y, color=look["color"], size=size, label=label)


def _errors(axes: "Axes", curve: Curve, floor: float | None) -> None:
    style.dress(axes)
    before, after = error(curve, "before"), error(curve, "after")
    factor = angle_unit([largest(before, after)])[1]
    if floor is not None:
        end = _BAND * floor * factor
        axes.axhspan(-end, end, color=style.BAND, alpha=0.25, lw=0.0, label="noise (95 %)")
    for y, colour in ((before, style.BEFORE), (after, style.AFTER)):
        if y is not None and dense(curve):
            axes.plot(curve.t, y * factor, color=colour, lw=1.0)
        elif y is not None:
            style.dots(axes, curve.t, y * factor, color=colour, size=1.4)
    axes.margins(x=0.0)


def _labels(curve: Curve) -> list[str]:
    """Of the angle above and the error below."""
    unit = angle_unit([largest(error(curve, "before"), error(curve, "after"))])[0]
    return [f"{CHANNELS[curve.channel]} [rad]", f"error [{unit}]"]


def described(diagnosis: DiagnosisRecord, index: int = 0) -> str:
    """The size of each error."""
    curves = curves_of(drawable(diagnosis.curves)[index])
    said = []
    for curve in curves:
        name = CHANNELS[curve.channel]
        before, after = rms(error(curve, "before")), rms(error(curve, "after"))
        if before is not None and after is not None:
            said.append(f"{name} {angle(before)} before and {angle(after)} after")
        elif before is not None:
            said.append(f"{name} {angle(before)}")
    return f"error (rms) {'; '.join(said)}" if said else ""
