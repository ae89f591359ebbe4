"""What is noted while a recording is made, and becomes its metadata."""

import time
from array import array
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._version import __version__
from tp_jax.acquisition.clock import ClockFit, fit_clock
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.frame_source import FrameSource
from tp_jax.acquisition.metadata import (
    calibration_entry,
    clock_entry,
    identity_entry,
    write_metadata,
)
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.settings import Settings
from tp_jax.acquisition.text_source import TextSource
from tp_jax.acquisition.timeline import Gap
from tp_jax.schemas.recording import VERSION

LISTED_FROM = 0.05
"""Seconds from which on a gap is listed by itself; shorter ones are only counted."""

MOST_LISTED = 1000

POLL = 1e-3
"""Seconds between two polls of a USB port."""

_EVERY = 5.0


class Log:
    """Notes on one recording.

    Attributes:
        duration: from the first to the last sample written [s], on the rig's clock.
    """

    def __init__(
        self,
        path: Path,
        port: Port,
        device: Device,
        source: FrameSource | TextSource,
        settings: Settings,
    ) -> None:
        self._path, self._port, self._device = path, port, device
        self._source, self._settings = source, settings
        self._identity = device.identity
        self._begin: float | None = None  # the first time of a text stream
        self._started: float | None = None
        self._rig, self._host = array("d"), array("d")
        self._fitted = 0  # arrivals at the last fit
        self._fit: ClockFit | None = None
        self._gaps: list[dict[str, Any]] = []
        self._gaps_not_listed = 0
        self._cause: str | None = None  # of the next gap
        self._lost_at_end = 0  # samples of gaps that reach beyond the run's end
        self._written = 0
        self._first = self._last = 0.0
        self._least = np.full(len(source.names), np.inf)
        self._largest = -self._least
        self._saved = 0.0

    @property
    def duration(self) -> float:
        return self._last - self._first

    def first_time(self, t: float) -> float:
        """The time the stream began with; the first call tells it."""
        if self._begin is None:
            self._begin = t
        return self._begin

    def arrived(self, t: float, host: float) -> None:
        """A sample of time t came at a time of the host's clock."""
        if self._settings.real_time:
            self._rig.append(t)
            self._host.append(host)
        if self._started is None:
            now = time.time()
            self._started = now - t if self._settings.real_time else now

    def unplugged(self, cause: str = "unplugged") -> None:
        """The next gap is that of a port that had gone, or of a rig not heard."""
        self._cause = cause

    def gaps(self, gaps: Iterable[Gap]) -> None:
        """Notes gaps."""
        for gap in gaps:
            begin = self._begin_of_run()
            if gap.before > (gap.after if begin is None else begin) + self._settings.duration:
                self._lost_at_end += gap.samples
            if gap.before - gap.after < LISTED_FROM and self._cause is None:
                continue
            if len(self._gaps) >= MOST_LISTED:
                self._gaps_not_listed += 1
                continue
            cause = self._cause or "lost"
            self._cause = None
            self._gaps.append(
                {
                    "after": gap.after,
                    "before": gap.before,
                    "samples": gap.samples,
                    "cause": cause,
                }
            )

    def wrote(self, values: np.ndarray) -> None:
        """Rows have been written; saves the metadata now and then."""
        if not self._written:
            self._first = float(values[0, 0])
        self._written += len(values)
        self._last = float(values[-1, 0])
        self._least = np.minimum(self._least, values.min(axis=0))
        self._largest = np.maximum(self._largest, values.max(axis=0))
        now = time.monotonic()
        if now - self._saved > _EVERY:
            self._saved = now
            write_metadata(self._path, self._content("recording", 0, 1.0, self._settings.omega))

    def clock(self) -> ClockFit | None:
        """The clock's fit; None where it cannot be told."""
        if self._fitted != len(self._rig):
            self._fitted = len(self._rig)
            poll = POLL if self._port.usb else 0.0
            self._fit = fit_clock(np.frombuffer(self._rig), np.frombuffer(self._host), poll)
        return self._fit

    def finish(
        self, state: str, cut: int, *, factor: float = 1.0, omega: float | None = None
    ) -> dict[str, Any]:
        """Writes the metadata; returns them."""
        return write_metadata(self._path, self._content(state, cut, factor, omega))

    def _content(self, state: str, cut: int, factor: float, omega: float | None) -> dict[str, Any]:
        source, settings = self._source, self._settings
        timeline = source.timeline
        spans = {
            name: (float(self._least[i]), float(self._largest[i]))
            for i, name in enumerate(source.names)
            if i and self._written
        }
        done = state != "recording"
        fit = self.clock() if done else None
        started = self._started if self._started is not None else time.time()
        gaps = [
            {**gap, "after": gap["after"] * factor, "before": gap["before"] * factor}
            for gap in self._gaps
        ]
        return {
            "schema": VERSION,
            "file": self._path.name,
            "columns": list(source.names),
            "state": state,
            "started": datetime.fromtimestamp(started, UTC).isoformat(),
            "command": list(settings.command),
            "port": self._port.name,
            "baud": self._port.baud,
            "stream": source.stream,
            "device": identity_entry(self._identity),
            "drive": {
                "omega": omega or None,
                "amplitude": settings.amplitude,
                "release": settings.release,
                "commanded": self._identity is not None and self._identity.drives,
            },
            "calibration": calibration_entry(source.angles.calibration, spans),
            "samples": {
                "written": self._written,
                "lost": self._lost(cut),
                "implausible": timeline.implausible,
                "clipped": source.angles.clipped,
            },
            "frames": source.frames(),
            "gaps": gaps,
            "gaps_not_listed": self._gaps_not_listed,
            "uncertain_turns": {
                name: [t * factor for t in times[:MOST_LISTED]]
                for name, times in source.angles.uncertain.items()
                if times
            },
            "clock": clock_entry(fit, factor != 1.0),
            "time": _TIME[source.stream] + (_CORRECTED if factor != 1.0 else ""),
            "version": __version__,
        }

    def _lost(self, cut: int) -> int:
        """Samples missing up to the last one written, or up to the run's end where it was reached.

        The timeline also counts those missing between the end and the first sample after it: by
        their times, but no more than the gap over the end has, since a clock may have jumped.
        """
        timeline = self._source.timeline
        if not cut or not timeline.period or timeline.last is None:
            return timeline.lost
        begin = self._begin_of_run() or 0.0
        whole = int(self._settings.duration / timeline.period + 0.25)
        beyond = round((timeline.last - begin) / timeline.period) - whole
        return timeline.lost - min(max(beyond - cut, 0), self._lost_at_end)

    def _begin_of_run(self) -> float | None:
        """Time of the run's begin [s]; None until a text stream has told."""
        return 0.0 if self._source.stream == "frames" else self._begin


_TIME = {
    "frames": "the rig's clock, 0 at the begin of the run",
    "text": "as the rig printed it",
}
_CORRECTED = ", times 1/(1 + skew) by the host's clock, omega times (1 + skew)"
