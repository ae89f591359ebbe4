"""Free runs over held-out recordings: measured, and the model before and after."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tp_jax.report import reading, style
from tp_jax.report.figures.curves import Curve, curves_of, drawable, error, largest, rms
from tp_jax.report.formatting import angle, angle_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CLOSE_POINTS = 90


def draw(
    diagnosis: Mapping[str, Any], index: int = 0, width: float = style.WIDE
) -> "Figure | None":
    """For each channel the angle above and the error below.

    Args:
        index: which of the recordings that have curves.
        width: in inches.

    Returns:
        None if there is no such recording.
    """
    entries = drawable(diagnosis, "curves")
    if index >= len(entries):
        return None
    channels = curves_of(entries[index])
    figure = style.new_figure(width, 0.5 + (3.1 if width >= style.WIDE else 2.9) * len(channels))
    rows = figure.subplots(
        2 * len(channels), 1, sharex=True, squeeze=False,
        height_ratios=[1.7, 1.0] * len(channels),
    )[:, 0]  # fmt: skip
    for curve, above, below in zip(channels, rows[::2], rows[1::2], strict=True):
        _angles(above, curve)
        _errors(below, curve)
        above.set_ylabel(f"{reading.CHANNELS[curve.channel]} [rad]")
    rows[-1].set_xlabel("time [s]")
    figure.align_ylabels(rows)
    style.legend(figure, rows[0])
    return figure


def close_up(diagnosis: Mapping[str, Any], width: float = style.BESIDE) -> "Figure | None":
    """The stretch of a free run in which the model before misses most, in one channel."""
    found = [
        curve
        for entry in drawable(diagnosis, "curves")[:1]
        for curve in curves_of(entry)
        if error(curve, "before") is not None
    ]
    if not found:
        return None
    curve = max(found, key=lambda curve: rms(error(curve, "before")) or 0.0)
    figure = style.new_figure(width, 3.5 if width >= style.BESIDE else 2.8)
    axes = figure.subplots()
    _angles(axes, _stretch(curve))
    axes.set_ylabel(f"{reading.CHANNELS[curve.channel]} [rad]")
    axes.set_xlabel("time [s]")
    style.legend(figure, axes)
    return figure


def _stretch(curve: Curve) -> Curve:
    """The points around the largest error of the model before."""
    miss = error(curve, "before")
    n = curve.t.size
    if miss is None or n <= _CLOSE_POINTS:
        return curve
    square = np.nan_to_num(miss) ** 2
    total = np.concatenate([[0.0], np.cumsum(square)])
    begin = int(np.argmax(total[_CLOSE_POINTS:] - total[:-_CLOSE_POINTS]))
    part = slice(begin, begin + _CLOSE_POINTS)
    return Curve(
        curve.channel,
        curve.t[part],
        *(None if y is None else y[part] for y in (curve.measured, curve.before, curve.after)),
    )


def _angles(axes: "Axes", curve: Curve) -> None:
    style.dress(axes)
    if curve.measured is not None:
        axes.plot(curve.t, curve.measured, color=style.BAND, lw=3.6, alpha=0.6, label="measured",
                  solid_capstyle="round")  # fmt: skip
    if curve.before is not None:
        axes.plot(curve.t, curve.before, color=style.BEFORE, lw=1.2, ls=(0, (5, 1.6)),
                  label="model" if curve.after is None else "before")  # fmt: skip
    if curve.after is not None:
        axes.plot(curve.t, curve.after, color=style.AFTER, lw=1.2, label="after")
    axes.margins(x=0.0)


def _errors(axes: "Axes", curve: Curve) -> None:
    style.dress(axes)
    before, after = error(curve, "before"), error(curve, "after")
    unit, factor = angle_unit([largest(before, after)])
    if before is not None:
        axes.plot(curve.t, before * factor, color=style.BEFORE, lw=1.0)
    if after is not None:
        axes.plot(curve.t, after * factor, color=style.AFTER, lw=1.0)
    axes.set_ylabel(f"error [{unit}]")
    axes.margins(x=0.0)


def described(diagnosis: Mapping[str, Any], index: int = 0) -> str:
    """The size of each error."""
    entry = drawable(diagnosis, "curves")[index]
    said = []
    for curve in curves_of(entry):
        name = reading.CHANNELS[curve.channel]
        before, after = rms(error(curve, "before")), rms(error(curve, "after"))
        if before is not None and after is not None:
            said.append(f"{name} {angle(before)} before and {angle(after)} after")
        elif before is not None:
            said.append(f"{name} {angle(before)}")
    return f"error (rms) {'; '.join(said)}" if said else ""
