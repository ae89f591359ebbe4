"""The record of one run: its file, its counts, and FILE.csv.meta.json beside FILE.csv.

The metadata are there from the first sample on and say `"state": "recording"` until the end, so
that a recording that was cut off tells so itself.

    {"schema": "tp-jax/recording/1", "file": "run.csv", "columns": ["t", "phi1", "phi2"],
     "state": "complete",              // recording | complete | interrupted | unplugged
                                       // | restarted | silent | failed
     "started": "2026-03-01T09:30:00.123456+00:00",    // host's clock at t = 0, UTC
     "command": ["tp-jax", "record", ...],
     "port": "/dev/ttyACM0", "baud": 460800, "stream": "frames",      // or "text"
     "device": {"name": "...", "boot": 1, "protocol": 1, "rate": 1000.0, ...},  // null: text
     "drive": {"omega": 13.09, "amplitude": null, "release": null,
               "commanded": true},     // false: a text stream, or a rig without a motor to command
     "calibration": {"source": "...", "phi1": {"law": "sine_cosine", ..., "standard_error":
                     {"angle": [..], "value": [..], "modes": [[..], ..], "largest": ..}}},  // rad
     "samples": {"written": 60001, "lost": 0, "implausible": 0, "clipped": {"phi1": 0}},
     "frames": {"good": 60003, "corrupt": 0, "unknown": 0},
     "gaps": [{"after": 20.0, "before": 23.001, "samples": 3000, "cause": "unplugged"}],  // s
     "gaps_not_listed": 0,
     "uncertain_turns": {"phi2": [23.001]},            // times at which a branch was guessed
     "clock": {"skew": 1.2e-6, "skew_error": .., "offset": .., "offset_error": .., "delay": ..,
               "applied": false},      // null: too short, or not in real time
     "time": "...",                    // in words, what the time column is
     "notes": ["..."]}                 // what was left out or changed, a sentence each

`standard_error` is the part of the angle's error that the calibration causes, the same for all
samples at an angle. `modes` are the shapes over the angle it is made of, independent of each other;
`value` is their root sum of squares (see `recordings.calibration_error`).
"""

import json
import math
import os
import time
from array import array
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import replaced
from tp_jax._version import __version__
from tp_jax.acquisition.calibration import Calibration, SensorCalibration
from tp_jax.acquisition.clock import ClockFit, fit_clock
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.protocol import BRIDGES
from tp_jax.acquisition.streams import Rows, Stream
from tp_jax.acquisition.writer import CsvWriter
from tp_jax.schemas.recording import VERSION

LISTED_FROM = 0.05
"""Seconds from which on a gap is listed by itself; shorter ones are only counted."""

MOST_LISTED = 1000

POLL = 1e-3
"""Seconds between two polls of a USB port."""

MOST_LEFT_OUT = 0.1
"""Share of the samples that came which may be left out of a recording that is as asked for."""

LEAST_WRITTEN = 0.5
"""Share of a run's samples that must be in the file for the same."""

_EVERY = 5.0  # seconds between two writings of the metadata
_PLOT_SAMPLES = 4000


@dataclass(frozen=True)
class Settings:
    """What is to be recorded, and how.

    Attributes:
        duration: from the begin of the run [s], both ends included.
        omega: of the drive [rad/s]; None: the motor stands at neutral.
        amplitude: of the drive [rad]; None: what the rig has.
        release: angle [rad] the column is let go from; excludes omega.
        calibration: None: what the rig announces, or nominal values.
        patience: seconds in which a rig must answer, and may be silent.
        reconnect: seconds in which an unplugged one must be back.
        real_time: whether the rig's clock is meant to run as the host's.
        command: that asked for it, for the metadata.
    """

    duration: float
    omega: float | None = None
    amplitude: float | None = None
    release: float | None = None
    calibration: Calibration | None = None
    patience: float = 5.0
    reconnect: float = 30.0
    real_time: bool = True
    command: Sequence[str] = ()


@dataclass(frozen=True)
class Status:
    """A recording in the making, for whoever shows it.

    Attributes:
        t: time of the last sample [s].
        duration: wanted [s].
        rate: samples per second of late, on the host's clock; None before it is known.
        written, lost: samples.
        corrupt: frames or lines.
        unplugged: whether the rig is waited for.
        names: of the columns.
        recent: (n, columns) the last samples.
    """

    t: float
    duration: float
    rate: float | None
    written: int
    lost: int
    corrupt: int
    unplugged: bool
    names: tuple[str, ...]
    recent: np.ndarray


Progress = Callable[[Status], None]


@dataclass(frozen=True)
class Recorded:
    """A recording that was written.

    Attributes:
        path: the file.
        state: how it ended: complete, interrupted, unplugged, restarted or silent.
        omega: of the drive [rad/s], on the time column; None where it was not driven.
        forced: whether the motor ran.
        duration: from the first to the last sample [s].
        metadata: as in the file beside it.
    """

    path: Path
    state: str
    omega: float | None
    forced: bool
    duration: float
    metadata: dict[str, Any]

    @property
    def rows(self) -> int:
        """Samples in the file."""
        return self.metadata["samples"]["written"]

    @property
    def fault(self) -> str | None:
        """Why it is not what was asked for, in one sentence; None where it is, or was stopped."""
        why = {
            "unplugged": "the rig was unplugged and did not come back",
            "restarted": "the rig has restarted, and its run with it",
            "silent": "the rig fell silent",
        }.get(self.state)
        if why is not None:
            return (
                f"The recording ended after {self.duration:.6g} s, since {why}; {self.path} keeps "
                f"the {self.rows} samples until then."
            )
        samples = self.metadata["samples"]
        lost, left_out = samples.get("lost", 0), samples.get("implausible", 0)
        enough = self.rows >= LEAST_WRITTEN * (self.rows + lost)
        if self.state != "complete" or (
            enough and left_out <= MOST_LEFT_OUT * (self.rows + left_out)
        ):
            return None
        return (
            f"{self.path} is not what was asked for: it has {self.rows} samples, {left_out} more "
            f"were left out and {lost} lost; see to the rig and record again."
        )


class RunLog:
    """Writes the samples of one run, and notes all there is to say about them.

    Attributes:
        state: "recording", and in the end how it ended.
        written: samples in the file.
        duration: from the first to the last of them [s], on the rig's clock.
    """

    def __init__(self, path: Path, port: Port, stream: Stream, settings: Settings) -> None:
        self.path, self.port, self.stream, self.settings = path, port, stream, settings
        self.state = "recording"
        self.written = 0
        self.duration = 0.0
        self._writer: CsvWriter | None = None
        # the clock of a text stream need not begin with the recording
        self._begin = 0.0 if stream.kind == "frames" else None
        self._cut = 0  # samples after the end
        self._started: float | None = None
        self._rig, self._host = array("d"), array("d")
        self._gaps: list[dict[str, Any]] = []
        self._gaps_not_listed = 0
        self._cause: str | None = None  # of the next gap
        self._lost_at_end = 0  # samples of gaps that reach beyond the run's end
        self._first = 0.0
        self._least = np.full(len(stream.names), np.inf)
        self._largest = -self._least
        self._saved = 0.0
        self._recent: deque[np.ndarray] = deque()
        self._rate: float | None = None
        self._counted = (0.0, 0)

    def take(self, rows: Rows) -> None:
        """Writes rows up to the end of the run, and says in `state` whether that was reached."""
        values, timeline = rows.values, self.stream.timeline
        if not len(values):
            return
        if rows.arrival is not None:
            self._arrived(*rows.arrival)
        self.note_gaps()
        period = timeline.period or 0.0
        if self._begin is None:
            self._begin = float(values[0, 0])
        end = self._begin + self.settings.duration
        inside = int(np.searchsorted(values[:, 0], end + 0.25 * period, "right"))
        self._cut += len(values) - inside
        if values[-1, 0] >= end - 0.25 * period:
            self.state = "complete"
        if inside:
            self._write(values[:inside])

    def next_gap(self, cause: str) -> None:
        """Says that the next gap is that of a port that had gone, or of a rig not heard."""
        self._cause = cause

    def note_gaps(self) -> None:
        """Notes the gaps that the timeline has found."""
        for gap in self.stream.timeline.take_gaps():
            begin = gap.after if self._begin is None else self._begin
            if gap.before > begin + self.settings.duration:
                self._lost_at_end += gap.samples
            if gap.before - gap.after < LISTED_FROM and self._cause is None:
                continue
            if len(self._gaps) >= MOST_LISTED:
                self._gaps_not_listed += 1
                continue
            self._gaps.append({**asdict(gap), "cause": self._cause or "lost"})
            self._cause = None

    def status(self, unplugged: bool) -> Status:
        """The state of things for somebody who looks on."""
        now, (since, before) = time.monotonic(), self._counted
        if now - since > 1.0:
            self._rate = (self.written - before) / (now - since) if since else None
            self._counted = (now, self.written)
        names, timeline = self.stream.names, self.stream.timeline
        return Status(
            t=max(timeline.last or 0.0, 0.0),
            duration=self.settings.duration,
            rate=self._rate,
            written=self.written,
            lost=timeline.lost,
            corrupt=self.stream.parser.corrupt,
            unplugged=unplugged,
            names=names,
            recent=np.concatenate([np.empty((0, len(names))), *self._recent]),
        )

    def clock(self) -> ClockFit | None:
        """The clock's fit; None where it cannot be told."""
        poll = POLL if self.port.usb else 0.0
        return fit_clock(np.frombuffer(self._rig), np.frombuffer(self._host), poll)

    def close(self) -> None:
        """Puts the file on the disk, and says in its metadata where that failed."""
        if self._writer is not None:
            self._writer.close()
            if self.state == "failed":
                self.save(None)

    def save(
        self, omega: float | None, fit: ClockFit | None = None, factor: float = 1.0
    ) -> dict[str, Any]:
        """Writes the metadata; returns them.

        Args:
            omega: of the drive [rad/s], on the time column.
            fit: of the rig's clock.
            factor: by which the times in the file were multiplied.
        """
        stream, settings = self.stream, self.settings
        ends = zip(stream.names, self._least.tolist(), self._largest.tolist(), strict=True)
        spans = {n: (low, high) for n, low, high in ends if n != "t" and self.written}
        started = time.time() if self._started is None else self._started
        identity, timeline, parser = stream.identity, stream.timeline, stream.parser
        device: dict[str, Any] | None = None
        if identity is not None:
            device = asdict(identity)
            del device["flags"], device["tag"]
            device["wired"] = [n for bit, n in enumerate(BRIDGES) if identity.wired >> bit & 1]
            device["amplitude"] = identity.amplitude or None
        content = {
            "schema": VERSION,
            "file": self.path.name,
            "columns": list(stream.names),
            "state": self.state,
            "started": datetime.fromtimestamp(started, UTC).isoformat(),
            "command": list(settings.command),
            "port": self.port.name,
            "baud": self.port.baud,
            "stream": stream.kind,
            "device": device,
            "drive": {
                "omega": omega or None,
                "amplitude": settings.amplitude,
                "release": settings.release,
                "commanded": identity is not None and identity.drives,
            },
            "calibration": calibration_entry(stream.calibration, spans),
            "samples": {
                "written": self.written,
                "lost": self._lost(),
                "implausible": timeline.implausible,
                "clipped": stream.clipped,
            },
            "frames": {"good": parser.good, "corrupt": parser.corrupt, "unknown": parser.unknown},
            "gaps": [
                {**gap, "after": gap["after"] * factor, "before": gap["before"] * factor}
                for gap in self._gaps
            ],
            "gaps_not_listed": self._gaps_not_listed,
            "uncertain_turns": {
                name: [t * factor for t in times[:MOST_LISTED]]
                for name, times in stream.uncertain.items()
                if times
            },
            "clock": None if fit is None else {**asdict(fit), "applied": factor != 1.0},
            "time": _TIME[stream.kind] + (_CORRECTED if factor != 1.0 else ""),
            "notes": stream.notes,
            "version": __version__,
        }
        return write_metadata(self.path, content)

    def _arrived(self, t: float, host: float) -> None:
        """Notes that a sample of time t came at a time of the host's clock."""
        if self.settings.real_time:
            self._rig.append(t)
            self._host.append(host)
        if self._started is None:
            self._started = time.time() - (t if self.settings.real_time else 0.0)

    def _write(self, values: np.ndarray) -> None:
        if self._writer is None:
            self._writer = CsvWriter(self.path, self.stream.names)
            self._first = float(values[0, 0])
        self._writer.write(values)
        self.written = self._writer.rows
        self.duration = float(values[-1, 0]) - self._first
        self._least = np.minimum(self._least, values.min(axis=0))
        self._largest = np.maximum(self._largest, values.max(axis=0))
        self._recent.append(values)
        while sum(map(len, self._recent)) > _PLOT_SAMPLES:
            self._recent.popleft()
        if time.monotonic() - self._saved > _EVERY:
            self._saved = time.monotonic()
            state, self.state = self.state, "recording"
            self.save(self.settings.omega)
            self.state = state

    def _lost(self) -> int:
        """Samples missing up to the last one written, or up to the run's end where it was reached.

        The timeline also counts those missing between the end and the first sample after it: by
        their times, but no more than the gap over the end has, since a clock may have jumped.
        """
        timeline = self.stream.timeline
        if not self._cut or not timeline.period or timeline.last is None:
            return timeline.lost
        whole = int(self.settings.duration / timeline.period + 0.25)
        beyond = round((timeline.last - (self._begin or 0.0)) / timeline.period) - whole
        return timeline.lost - min(max(beyond - self._cut, 0), self._lost_at_end)


_TIME = {
    "frames": "the rig's clock, 0 at the begin of the run",
    "text": "as the rig printed it",
}
_CORRECTED = ", times 1/(1 + skew) by the host's clock, omega times (1 + skew)"


def metadata_path(recording: str | os.PathLike[str]) -> Path:
    """The place of a recording's metadata."""
    return Path(f"{os.fspath(recording)}.meta.json")


def write_metadata(recording: Path, content: Mapping[str, Any]) -> dict[str, Any]:
    """Writes or replaces a recording's metadata; returns them in JSON's own types."""
    plain = _plain(content)
    text = json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with replaced(metadata_path(recording)) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return plain


def calibration_entry(
    calibration: Calibration, spans: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    """The calibration with its standard errors over the angles that were recorded.

    Args:
        calibration: of the rig.
        spans: sensor -> least and largest angle [rad] recorded, where there are any yet.
    """
    usual = (-0.25 * math.pi, 0.25 * math.pi)
    sensors = calibration.sensors.items()
    return {
        "source": calibration.source,
        **{n: _sensor_entry(sensor, *spans.get(n, usual)) for n, sensor in sensors},
    }


def _sensor_entry(sensor: SensorCalibration, low: float, high: float) -> dict[str, Any]:
    if high - low >= math.pi and sensor.law != "line":
        # a bridge repeats itself after half a turn: a ring that winds needs no more of it
        low, high = -0.5 * math.pi, 0.5 * math.pi
    angle = np.linspace(low, max(high, low + 1e-3), 25)  # of a body that never moved as well
    error, modes = sensor.standard_error(angle), sensor.error_modes(angle)
    return {
        "law": sensor.law,
        **sensor.parameters,
        "errors": sensor.errors,
        "covariance": sensor.covariance,
        "span": sensor.span,
        "residual": sensor.residual,
        "standard_error": {
            "angle": angle,
            "value": error,
            "modes": modes[modes.any(axis=1)],
            "largest": float(error.max()),
        },
    }


def _plain(value: Any) -> Any:
    """The value in JSON's own types; NaN and infinities become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
