"""The record of one run: its file, its counts, and FILE.csv.meta.json beside FILE.csv.

The metadata (docs/recording.md shows them) are there from the first sample on and say
`"state": "recording"` until the end, so that a recording that was cut off tells so itself.
"""

import contextlib
import time
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import write_json
from tp_jax._version import __version__
from tp_jax.acquisition.clock import ClockFit, fit_clock
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.protocol import BRIDGES
from tp_jax.acquisition.streams import Rows, Stream
from tp_jax.acquisition.writer import CsvWriter
from tp_jax.recordings.calibration import Calibration, calibration_entry
from tp_jax.schemas.recording import VERSION, metadata_path

LISTED_FROM = 0.05  # seconds of a gap that is listed by itself; shorter ones are only counted
MOST_LISTED = 1000
POLL = 1e-3  # seconds between two polls of a USB port

# A recording is as asked for with up to this share of what came left out, and at least that share
# of the run's samples in the file: a bad line loses some, a clock that cannot be read loses most.
MOST_LEFT_OUT, LEAST_WRITTEN = 0.1, 0.5

_EVERY = 5.0  # seconds between two writings of the metadata
_PLOT_SAMPLES = 4000


@dataclass(frozen=True)
class Settings:
    """The run that is to be recorded, and how."""

    duration: float  # from the begin of the run [s], both ends included
    omega: float | None = None  # of the drive [rad/s]; None: the motor stands at neutral
    amplitude: float | None = None  # of the drive [rad]; None: that of the rig
    release: float | None = None  # angle [rad] the column is let go from; excludes omega
    calibration: Calibration | None = None  # None: that which the rig announces, or nominal values
    patience: float = 5.0  # seconds in which a rig must answer, and may be silent
    reconnect: float = 30.0  # seconds in which an unplugged one must be back
    real_time: bool = True  # the rig's clock is meant to run as the host's
    command: Sequence[str] = ()  # that asked for it, for the metadata


@dataclass(frozen=True)
class Status:
    """A recording in the making, for whoever shows it."""

    t: float  # time of the last sample [s]
    duration: float  # wanted [s]
    rate: float | None  # samples per second of late, on the host's clock; None: not known yet
    written: int  # samples
    lost: int  # samples
    corrupt: int  # frames or lines
    unplugged: bool  # the rig is waited for
    names: tuple[str, ...]  # of the columns
    recent: np.ndarray  # (n, columns) the last samples


Progress = Callable[[Status], None]


@dataclass(frozen=True)
class Recorded:
    """A recording that was written."""

    path: Path
    state: str  # how it ended: complete, interrupted, unplugged, restarted or silent
    omega: float | None  # of the drive [rad/s], on the time column; None: it was not driven
    forced: bool  # the motor ran
    duration: float  # from the first to the last sample [s]
    metadata: dict[str, Any]  # as in the file beside it

    @property
    def rows(self) -> int:
        """Samples in the file."""
        return self.metadata["samples"]["written"]

    @property
    def fault(self) -> str | None:
        """The reason why it is not as asked for; None where it is, or where Ctrl-C ended it."""
        why = {
            "unplugged": "the rig was unplugged and did not come back",
            "restarted": "the rig has restarted, and its run with it",
            "silent": "the rig fell silent",
        }.get(self.state)
        lost, left_out = (self.metadata["samples"].get(n, 0) for n in ("lost", "implausible"))
        few = self.rows < LEAST_WRITTEN * (self.rows + lost)
        if why is not None:
            told = (
                f"The recording ended after {self.duration:.6g} s, since {why}; {self.path} keeps "
                f"the {self.rows} samples until then."
            )
        elif self.state == "complete" and (
            few or left_out > MOST_LEFT_OUT * (self.rows + left_out)
        ):
            told = (
                f"{self.path} is not what was asked for: it has {self.rows} samples of the run, "
                f"and {lost} are lost."
            )
        else:
            return None
        return " ".join([told, *self.metadata.get("notes", [])])


class RunLog:
    """Writes the samples of one run, and notes all there is to say about them."""

    def __init__(self, path: Path, port: Port, stream: Stream, settings: Settings) -> None:
        self.path, self.port, self.stream, self.settings = path, port, stream, settings
        self.state = "recording"  # and in the end how it ended
        self.written = 0  # samples in the file
        self.duration = 0.0  # from the first to the last of them [s], on the rig's clock
        self.cause: str | None = None  # of the next gap; None: samples were lost on the way
        self.notes: list[str] = []  # sentences besides those of the stream
        self._writer: CsvWriter | None = None
        # the clock of a text stream need not begin with the recording
        self._begin = 0.0 if stream.kind == "frames" else None
        self._first = 0.0
        self._least = np.full(len(stream.names), np.inf)
        self._largest = -self._least
        self._cut = 0  # samples after the end
        self._started: float | None = None
        self._rig, self._host = array("d"), array("d")
        self._gaps: list[dict[str, Any]] = []
        self._gaps_not_listed = 0
        self._lost_at_end = 0  # samples of gaps that reach beyond the run's end
        self._saved = 0.0
        self._recent = np.empty((0, len(stream.names)))
        self._rate: float | None = None
        self._counted = (0.0, 0)

    def take(self, rows: Rows) -> None:
        """Writes rows up to the end of the run, and says in `state` whether that was reached."""
        values, period = rows.values, self.stream.timeline.period or 0.0
        if not len(values):
            return
        if rows.arrival is not None:
            t, host = rows.arrival
            real_time = self.settings.real_time
            if real_time:
                self._rig.append(t)
                self._host.append(host)
            if self._started is None:
                self._started = time.time() - (t if real_time else 0.0)
        self.note_gaps()
        if self._begin is None:
            self._begin = float(values[0, 0])
        end = self._begin + self.settings.duration
        inside = int(np.searchsorted(values[:, 0], end + 0.25 * period, "right"))
        self._cut += len(values) - inside
        if inside:
            self._write(values[:inside])
        if values[-1, 0] >= end - 0.25 * period:
            self.state = "complete"

    def note_gaps(self) -> None:
        """Notes the gaps that the timeline has found."""
        for gap in self.stream.timeline.take_gaps():
            begin = gap.after if self._begin is None else self._begin
            if gap.before > begin + self.settings.duration:
                self._lost_at_end += gap.samples
            if gap.before - gap.after < LISTED_FROM and self.cause is None:
                continue
            if len(self._gaps) < MOST_LISTED:
                self._gaps.append({**asdict(gap), "cause": self.cause or "lost"})
                self.cause = None
            else:
                self._gaps_not_listed += 1

    def status(self, unplugged: bool) -> Status:
        """The state of things for somebody who looks on."""
        now, (since, before) = time.monotonic(), self._counted
        if now - since > 1.0:
            self._rate = (self.written - before) / (now - since) if since else None
            self._counted = (now, self.written)
        timeline = self.stream.timeline
        return Status(
            t=max(timeline.last or 0.0, 0.0),
            duration=self.settings.duration,
            rate=self._rate,
            written=self.written,
            lost=timeline.lost,
            corrupt=self.stream.parser.corrupt,
            unplugged=unplugged,
            names=self.stream.names,
            recent=self._recent,
        )

    def clock(self) -> ClockFit | None:
        """The clock's fit; None where it cannot be told."""
        poll = POLL if self.port.usb else 0.0
        return fit_clock(np.frombuffer(self._rig), np.frombuffer(self._host), poll)

    def close(self) -> None:
        """Puts the file on the disk, and says in its metadata where the recording failed."""
        if self._writer is not None:
            self._writer.close()
            if self.state == "failed":
                with contextlib.suppress(OSError):  # of a full disk: what was wrong is told already
                    self.save(None)

    def save(
        self, omega: float | None, fit: ClockFit | None = None, factor: float = 1.0
    ) -> dict[str, Any]:
        """Writes the metadata, times multiplied by the factor as in the file; returns them."""
        return write_metadata(self.path, self._content(omega, fit, factor))

    def _content(self, omega: float | None, fit: ClockFit | None, factor: float) -> dict[str, Any]:
        stream, settings, identity = self.stream, self.settings, self.stream.identity
        ends = zip(stream.names, self._least.tolist(), self._largest.tolist(), strict=True)
        spans = {n: (low, high) for n, low, high in ends if n != "t" and self.written}
        started = time.time() if self._started is None else self._started
        corrected = ", times 1/(1 + skew) by the host's clock, omega times (1 + skew)"
        device: dict[str, Any] | None = None
        if identity is not None:
            device = asdict(identity)
            del device["flags"], device["tag"]
            device["wired"] = [n for bit, n in enumerate(BRIDGES) if identity.wired >> bit & 1]
            device["amplitude"] = identity.amplitude or None
        return {
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
                "implausible": stream.timeline.implausible,
                "clipped": stream.clipped,
            },
            "frames": {n: getattr(stream.parser, n) for n in ("good", "corrupt", "unknown")},
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
            "time": stream.time + (corrected if factor != 1.0 else ""),
            "notes": [*stream.notes, *self.notes],
            "version": __version__,
        }

    def _write(self, values: np.ndarray) -> None:
        if self._writer is None:
            self._writer = CsvWriter(self.path, self.stream.names)
            self._first = float(values[0, 0])
        self._writer.write(values)
        self.written = self._writer.rows
        self.duration = float(values[-1, 0]) - self._first
        self._least = np.minimum(self._least, values.min(axis=0))
        self._largest = np.maximum(self._largest, values.max(axis=0))
        self._recent = np.concatenate([self._recent, values])[-_PLOT_SAMPLES:]
        if time.monotonic() - self._saved > _EVERY:
            self._saved = time.monotonic()
            content = self._content(self.settings.omega, None, 1.0)
            self._writer.beside(lambda: write_metadata(self.path, content))

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


def write_metadata(recording: Path, content: Mapping[str, Any]) -> dict[str, Any]:
    """Writes or replaces a recording's metadata; returns them in JSON's own types."""
    return write_json(metadata_path(recording), content)
