"""Recording a run: from the port to a file that is complete up to the last moment.

The time column is the rig's own clock, zero where the run began. While the run is on it is written
as it is; when it has ended, and the host's clock says beyond doubt that the rig's is wrong (see
`correction`), all times are multiplied by one factor, so that uniform sampling stays uniform. The
drive hangs on the same clock, so its frequency is corrected with it.
"""

import logging
import signal
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.clock import ClockFit
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.frame_source import FrameSource
from tp_jax.acquisition.log import Log
from tp_jax.acquisition.metadata import metadata_path
from tp_jax.acquisition.port import Port, Unplugged
from tp_jax.acquisition.recorded import Recorded
from tp_jax.acquisition.rig_calibration import rig_calibration
from tp_jax.acquisition.rows import Rows
from tp_jax.acquisition.settings import Settings
from tp_jax.acquisition.status import Progress, Status
from tp_jax.acquisition.text_source import TextSource
from tp_jax.acquisition.writer import CsvWriter, already_there, scale_time
from tp_jax.errors import InputError

_LOG = logging.getLogger(__name__)

SIGNIFICANT_SKEW = 5e-5
"""A host's own clock is a crystal as well: below this either of the two may be to blame."""

SIGNIFICANT_ERRORS = 3.0

LARGEST_SKEW = 0.2
"""The worst oscillator, of a resistor and a capacitor, is wrong by a tenth. More is no skew: what
is behind the port does not keep the time that it writes."""

LARGEST_RELEASE = 0.5 * np.pi
"""rad; from further on the bridges cannot tell which turn a run began in."""

_STATUS_PERIOD = 0.1
_PLOT_SAMPLES = 4000


def record(
    port: Port | str,
    out: str | Path,
    settings: Settings,
    *,
    baud: int = protocol.BAUD,
    progress: Progress | None = None,
) -> Recorded:
    """Records one run.

    Ctrl-C ends it early and keeps what there is.

    Args:
        port: an open port, or the name of one, which is closed in the end.
        out: the file, which must not exist yet.
        settings: what is to be recorded.
        baud: for a port that is opened here.
        progress: called some ten times a second.

    Raises:
        InputError: the port, the rig or the file cannot be used, or nothing came: no file is
            left then.
    """
    path = Path(out)
    check(path, settings)
    own = port if isinstance(port, Port) else Port(port, baud)
    try:
        return _Recorder(own, path, settings, progress).run()
    except Unplugged as fault:
        raise InputError(
            f"The port {own.name} has gone before the recording began; plug the rig in again."
        ) from fault
    finally:
        own.close()


def check(path: Path, settings: Settings) -> None:
    """What can be seen before the port is opened.

    Raises:
        InputError: the settings contradict each other, or there is such a file already.
    """
    if settings.omega is not None and settings.release is not None:
        raise InputError("A run is driven or released, not both; give omega or release.")
    if not settings.duration > 0.0:
        raise InputError(f"The duration must be above zero, but is {settings.duration:g} s.")
    for each in (path, metadata_path(path)):
        if each.exists() or each.is_symlink():
            raise InputError(already_there(each))


def correction(fit: ClockFit | None) -> float:
    """Factor on the times of a recording, for the skew of the rig's clock; 1: none.

    A skew is corrected where it is larger than the host's own clock may be wrong by, and than
    three of its standard errors, and no larger than that of the worst oscillator.
    """
    if fit is None or abs(fit.skew) <= max(SIGNIFICANT_SKEW, SIGNIFICANT_ERRORS * fit.skew_error):
        return 1.0
    if abs(fit.skew) > LARGEST_SKEW:
        _LOG.warning(
            "The rig's clock ran at %.3g times the host's; its times are left as they are.",
            1.0 + fit.skew,
        )
        return 1.0
    return 1.0 / (1.0 + fit.skew)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Another Ctrl-C does not keep a recording from being closed and described; a second or two."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class _Recorder:
    """One recording; used once."""

    def __init__(
        self, port: Port, path: Path, settings: Settings, progress: Progress | None
    ) -> None:
        self.port, self.path, self.settings, self.progress = port, path, settings, progress
        self.device = Device(port)
        self.writer: CsvWriter | None = None
        self.state = "recording"
        self.cut = 0  # samples after the end
        self.omega: float | None = None
        self._asked = False
        self._recent: deque[np.ndarray] = deque()
        self._shown = 0.0
        self._rate: float | None = None
        self._counted = (0.0, 0)

    def run(self) -> Recorded:
        self.device.identify(self.settings.patience)
        source = self._begin()
        log = Log(self.path, self.port, self.device, source, self.settings)
        try:
            self._loop(source, log)
        except KeyboardInterrupt:
            self.state = "interrupted"
        except OSError as fault:  # of the file: those of the port are `Unplugged`
            self.state = "failed"
            raise InputError(
                f"Cannot write {self.path}: {fault.strerror}; it keeps what was written until then."
            ) from fault
        except BaseException:
            self.state = "failed"
            raise
        finally:
            with uninterrupted():
                self._end(source, log)
        if self.writer is None:
            raise InputError(
                f"No sample came from {self.port.name} after the run was started; check that the "
                "firmware samples."
            )
        with uninterrupted():
            return self._finished(log)

    # The run --------------------------------------------------------------------------------

    def _begin(self) -> FrameSource | TextSource:
        """Starts the run."""
        wanted = self.settings
        if self.device.identity is None:
            return TextSource(self.device, wanted.calibration)
        if self.device.identity.running:  # what another recorder left
            self.device.command(protocol.STOP)
        calibration = rig_calibration(self.device, wanted.calibration, wanted.patience)
        drives = self.device.identity.drives
        if wanted.omega and not drives:
            raise InputError(
                f"The rig at {self.port.name} has no motor to command; record without --omega."
            )
        self.omega = wanted.omega
        if drives and wanted.release is None:
            ack = self.device.command(protocol.DRIVE, wanted.omega or 0.0, wanted.amplitude or 0.0)
            if wanted.omega:
                self.omega = ack.value / 1e6
        self.device.samples.clear()
        if wanted.release is not None and abs(wanted.release) >= LARGEST_RELEASE:
            raise InputError(
                f"The column cannot be let go at {wanted.release:g} rad: its sensor repeats itself "
                "after half a turn; give an angle within ±1.57."
            )
        if wanted.release is not None:
            begun = self.device.command(protocol.RELEASE, wanted.release)
        else:
            begun = self.device.command(protocol.START)
        return FrameSource(self.device, calibration, begun)

    def _loop(self, source: FrameSource | TextSource, log: Log) -> None:
        for rows in source.pending():
            self._take(rows, source, log)
        heard = time.monotonic()
        while self.state == "recording":
            try:
                data, arrival = self.port.read(0.05)
            except Unplugged:
                self._wait_for_the_rig(source, log)
                heard = time.monotonic()
                continue
            if data:
                rows = source.feed(data, arrival)
                self._take(rows, source, log)
                if len(rows.values):
                    heard, self._asked = time.monotonic(), False
            if source.timeline.restarted:
                self.state = "restarted"
            elif self.state == "recording" and (time.monotonic() - heard > self.settings.patience):
                self._ask_after(source, log)
                heard = time.monotonic()
            self._show(source)

    def _take(self, rows: Rows, source: FrameSource | TextSource, log: Log) -> None:
        """Writes rows up to the end of the run."""
        values = rows.values
        if not len(values):
            return
        if rows.arrival is not None:
            log.arrived(*rows.arrival)
        log.gaps(source.timeline.take_gaps())
        period = source.timeline.period or 0.0
        # a text stream's clock need not begin with the recording
        begin = 0.0 if source.stream == "frames" else log.first_time(float(values[0, 0]))
        end = begin + self.settings.duration
        inside = int(np.searchsorted(values[:, 0], end + 0.25 * period, "right"))
        self.cut += len(values) - inside
        if values[-1, 0] >= end - 0.25 * period:
            self.state = "complete"
        values = values[:inside]
        if not len(values):
            return
        if self.writer is None:
            self.writer = CsvWriter(self.path, source.names)
        self.writer.write(values)
        log.wrote(values)
        if self.progress is not None:
            self._recent.append(values)
            while sum(map(len, self._recent)) > _PLOT_SAMPLES:
                self._recent.popleft()

    def _ask_after(self, source: FrameSource | TextSource, log: Log) -> None:
        """Silence, though the port is there: a cable is out further on, or the rig has stopped."""
        self.state = "silent"
        if source.stream == "text" or self._asked:
            return
        self._asked = True  # once: a rig that answers and sends no samples will not send any
        log.unplugged("silent")
        source.timeline.interrupted()
        self.device.forget()
        try:
            self.device.identify(self.settings.reconnect)
        except InputError:
            return
        except Unplugged:
            self.state = "recording"  # the port has gone now: seen when it is read
            return
        if source.same_run():
            self.state = "recording"
            for rows in source.pending():
                self._take(rows, source, log)

    def _wait_for_the_rig(self, source: FrameSource | TextSource, log: Log) -> None:
        """Until it is plugged in again, or for as long as one may wait."""
        deadline = time.monotonic() + self.settings.reconnect
        log.unplugged()
        while time.monotonic() < deadline:
            self._show(source, unplugged=True)
            if not self.port.reopen():
                time.sleep(0.1)
                continue
            self.device.forget()
            source.timeline.interrupted()
            if source.stream == "text":
                return
            try:
                self.device.identify(self.settings.patience)
            except Unplugged:
                continue
            except InputError:
                continue  # bytes of another baud, while a board starts: ask again
            if not source.same_run():
                self.state = "restarted"
                return
            for rows in source.pending():
                self._take(rows, source, log)
            return
        self.state = "unplugged"

    def _show(self, source: FrameSource | TextSource, unplugged: bool = False) -> None:
        now = time.monotonic()
        if self.progress is None or now - self._shown < _STATUS_PERIOD:
            return
        self._shown = now
        written = 0 if self.writer is None else self.writer.rows
        since, before = self._counted
        if now - since > 1.0:
            self._rate = (written - before) / (now - since) if since else None
            self._counted = (now, written)
        recent = list(self._recent)
        self.progress(
            Status(
                t=max(source.timeline.last or 0.0, 0.0),
                duration=self.settings.duration,
                rate=self._rate,
                written=written,
                lost=source.timeline.lost,
                corrupt=source.frames()["corrupt"],
                unplugged=unplugged,
                names=source.names,
                recent=np.concatenate(recent) if recent else np.empty((0, len(source.names))),
            )
        )

    # The end --------------------------------------------------------------------------------

    def _end(self, source: FrameSource | TextSource, log: Log) -> None:
        """Stops the rig and closes the file, whatever happened."""
        if source.stream == "text" and self.state in ("complete", "interrupted", "silent"):
            rest = source.last_rows()  # type: ignore[union-attr]
            if rest is not None:
                self._take(rest, source, log)
        if self.state != "unplugged":
            try:
                self.device.stop()
            except Unplugged:
                pass
        if self.writer is not None:
            self.writer.close()
            if self.state == "failed":
                log.finish(self.state, self.cut)

    def _finished(self, log: Log) -> Recorded:
        """Corrects the clock and writes down what there is to say."""
        fit = log.clock()
        factor = correction(fit)
        if factor != 1.0:
            scale_time(self.path, factor)
        commanded = self.device.identity is not None and self.device.identity.drives
        omega = self.omega if commanded else self.settings.omega
        if omega and commanded:
            omega /= factor
        metadata = log.finish(self.state, self.cut, factor=factor, omega=omega)
        return Recorded(
            path=self.path,
            state=self.state,
            omega=omega or None,
            forced=bool(omega),
            duration=log.duration * factor,
            metadata=metadata,
        )
