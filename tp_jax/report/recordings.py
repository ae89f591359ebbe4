"""One figure of a campaign's recordings: `tp-jax check --figure`."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.checks.harmonics import spectrum
from tp_jax.errors import InputError
from tp_jax.report import style

if TYPE_CHECKING:
    from tp_jax.checks import Checked
    from tp_jax.recordings import Recording

_MOST = 12
"""Recordings in a figure; those with findings come first."""

_SHOWN = 8.0
"""Periods of the drive that are drawn; more would be a band of ink."""

_ROW = 1.35
"""Inches of a recording."""


def draw_recordings(checked: "Checked", path: Path, kind: str = "png") -> None:
    """Draws the end of each recording, and phi1's spectrum with the frequency that was said.

    Args:
        checked: a campaign that was checked.
        path: written as what `kind` says, "png" or "svg".
        kind: of the file.

    Raises:
        InputError: the kind is another, or there is no recording to draw.
    """
    if kind not in ("png", "svg"):
        raise InputError(f"A figure is written as .png or .svg, but not as .{kind}.")
    if checked.campaign is None:
        raise InputError("There is no recording to draw.")
    told = {label: each for each in reversed(checked.findings) for label in each.recordings}
    recordings = sorted(checked.campaign.recordings, key=lambda r: r.label not in told)[:_MOST]
    figure = style.new_figure(style.WIDE, 0.6 + _ROW * len(recordings), fitted=True)
    axes = figure.subplots(len(recordings), 2, squeeze=False, width_ratios=(2, 1))
    for row, recording in zip(axes, recordings, strict=True):
        _draw_angles(row[0], recording)
        _draw_spectrum(row[1], recording)
        finding = told.get(recording.label)
        words = "" if finding is None else f"  {finding.level}: {finding.kind}"
        style.title(row[0], recording.label + words)
        if finding is not None:
            row[0].title.set_color(style.BEFORE)
    axes[-1][0].set_xlabel("time [s]")
    axes[-1][1].set_xlabel("frequency [rad/s]")
    style.title(axes[0][1], "φ1's spectrum [rad]; line: omega")
    style.legend(figure, axes[0][0])
    figure.savefig(path, format=kind, dpi=style.PIXELS, facecolor="white")


def _draw_angles(axes, recording: "Recording") -> None:
    begin = recording.t[-1] - drawn_duration(recording.duration, recording.omega)
    part = recording.t >= begin
    t = recording.t[part]
    axes.plot(t, recording.phi1[part], color=style.MUTED, lw=1.0, label="φ1, the column [rad]")
    if recording.phi2 is not None:
        axes.plot(t, recording.phi2[part], color=style.AFTER, lw=1.0, label="φ2, the rider [rad]")
    style.dress(axes)
    axes.margins(x=0.0)


def drawn_duration(duration: float, omega: float | None) -> float:
    """Seconds at the end of a recording that are drawn: some periods of a drive, all of a decay.

    Args:
        duration: of the recording [s].
        omega: of its drive [rad/s]; None: a decay, or not known.
    """
    if omega is None:
        return duration
    return min(duration, _SHOWN * 2.0 * math.pi / omega)


def _draw_spectrum(axes, recording: "Recording") -> None:
    frequency, amplitude = spectrum(recording.t, recording.phi1)
    axes.loglog(frequency[1:], amplitude[1:], color=style.MUTED, lw=0.8)
    if recording.omega is not None:
        axes.axvline(recording.omega, color=style.BEFORE, lw=1.2)
    axes.set_ylim(amplitude.max() * 1e-4, amplitude.max() * 3.0)
    style.dress(axes)
