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
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.clock import ClockFit
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.port import Port, Unplugged
from tp_jax.acquisition.run_log import Progress, Recorded, RunLog, Settings, metadata_path
from tp_jax.acquisition.streams import Stream
from tp_jax.acquisition.writer import already_there, scale_time
from tp_jax.errors import InputError

_LOG = logging.getLogger(__name__)

# A host's own clock is a crystal as well: below a skew of 5e-5 either of the two may be to blame.
# The worst oscillator, of a resistor and a capacitor, is wrong by a tenth: a rig that seems more so
# does not keep the time that it writes.
SIGNIFICANT_SKEW, LARGEST_SKEW = 5e-5, 0.2
SIGNIFICANT_ERRORS = 3.0
STRAIGHT = 0.8  # part of a skew by which that of a half may differ: more is a jump of a clock

LARGEST_RELEASE = 0.5 * np.pi  # rad; beyond, no bridge tells which turn a run began in
_STATUS_PERIOD = 0.1

MAY_STILL_RUN = "The rig did not confirm that it stopped, and may still run; switch its motor off."


def record(
    port: Port | str,
    out: str | Path,
    settings: Settings,
    *,
    baud: int = protocol.BAUD,
    progress: Progress | None = None,
    ready: Callable[[], None] | None = None,
) -> Recorded:
    """Records one run. Ctrl-C ends it early and keeps what there is.

    So do a SIGTERM, and a terminal that is closed: the rig is told to stop.

    Args:
        port: an open port, or the name of one, which is closed in the end.
        out: the file, which must not exist yet.
        settings: of the run.
        baud: for a port that is opened here.
        progress: called some ten times a second.
        ready: called once the rig has answered, just before the run begins; a rig that sends lines
            of text has begun by then.

    Raises:
        InputError: the port, the rig or the file cannot be used, or nothing came: no file is
            left then.
    """
    path = Path(out)
    check(path, settings)
    own = port if isinstance(port, Port) else Port(port, baud)
    try:
        with _ended_like_ctrl_c():
            return _Recorder(own, path, settings, progress).run(ready)
    except Unplugged as fault:
        raise InputError(
            f"The port {own.name} has gone before the recording began; plug the rig in again."
        ) from fault
    finally:
        own.close()


def check(path: Path, settings: Settings) -> None:
    """Faults settings that contradict each other, and a file that is there already."""
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
    three of its standard errors, no larger than that of the worst oscillator, and that of both
    halves. A computer that sleeps while the rig goes on, or a rig's clock that jumps, has no skew.
    """
    if fit is None or abs(fit.skew) <= max(SIGNIFICANT_SKEW, SIGNIFICANT_ERRORS * fit.skew_error):
        return 1.0
    if abs(fit.skew) > LARGEST_SKEW:
        _LOG.warning(
            "The rig's clock ran at %.3g times the host's; its times are left as they are.",
            1.0 + fit.skew,
        )
        return 1.0
    if jumped(fit):
        _LOG.warning("One of the two clocks jumped; the rig's times are left as they are.")
        return 1.0
    return 1.0 / (1.0 + fit.skew)


def jumped(fit: ClockFit) -> bool:
    """True where the two clocks did not run at one rate all through."""
    return fit.bend > STRAIGHT * abs(fit.skew)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Another Ctrl-C does not keep a recording from being closed and described; a second or two."""
    with _on_signals(signal.SIG_IGN, (signal.SIGINT, *_endings())):
        yield


@contextmanager
def _ended_like_ctrl_c() -> Iterator[None]:
    """A SIGTERM or a closed terminal raises KeyboardInterrupt: else the motor would run on.

    A signal that is ignored, as by nohup, or that the program handles itself, stays so.
    """

    def interrupt(_: int, frame: object) -> None:  # noqa: ARG001
        raise KeyboardInterrupt

    left = [each for each in _endings() if signal.getsignal(each) == signal.SIG_DFL]
    with _on_signals(interrupt, left):
        yield


def _endings() -> tuple[int, ...]:
    """Signals, beside Ctrl-C's, that end a program; Windows has one of them."""
    names = ("SIGTERM", "SIGHUP")
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


@contextmanager
def _on_signals(
    handler: Callable[[int, object], None] | signal.Handlers, numbers: Iterable[int]
) -> Iterator[None]:
    """Handles signals so for a while; only a main thread can."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, own in before.items():
            signal.signal(number, own)


class _Recorder:
    """One recording; used once."""

    log: RunLog
    stream: Stream

    def __init__(
        self, port: Port, path: Path, settings: Settings, progress: Progress | None
    ) -> None:
        self.port, self.path, self.settings, self.progress = port, path, settings, progress
        self.device = Device(port)
        self.omega = settings.omega
        self._shown = 0.0

    def run(self, ready: Callable[[], None] | None) -> Recorded:
        self.device.identify(self.settings.patience)
        if ready is not None:
            ready()
        try:
            self.stream = self._begin()
        except BaseException:
            # The rig may have begun its run although its answer was never seen.
            stopped = False
            with uninterrupted(), suppress(Unplugged):
                stopped = self.device.stop()
            if not stopped and self.omega:
                _LOG.warning(MAY_STILL_RUN)
            raise
        self.log = log = RunLog(self.path, self.port, self.stream, self.settings)
        try:
            self._loop()
        except KeyboardInterrupt:
            log.state = "interrupted"
        except BaseException as fault:
            log.state = "failed"
            if isinstance(fault, OSError):  # of the file: those of the port are `Unplugged`
                raise InputError(
                    f"Cannot write {self.path}: {fault.strerror}; it keeps what was written until "
                    "then."
                ) from fault
            raise
        finally:
            with uninterrupted():
                self._end()
        if not log.written:
            why = " ".join(self.stream.notes) or "check that the firmware samples."
            raise InputError(
                " ".join(
                    [
                        f"No sample came from {self.port.name} after the run was started; {why}",
                        *log.notes,
                    ]
                )
            )
        with uninterrupted():
            return self._finished()

    def _begin(self) -> Stream:
        """Starts the run."""
        wanted, identity, tell = self.settings, self.device.identity, self.device.command
        if identity is not None and identity.running:  # another recorder left it so
            tell(protocol.STOP)
        calibration = self.device.calibration(wanted.calibration, wanted.patience)
        if identity is None:
            return Stream(self.device, calibration, real_time=wanted.real_time)
        if wanted.omega and not identity.drives:
            raise InputError(
                f"The rig at {self.port.name} has no motor to command; record without --omega."
            )
        if wanted.release is not None and abs(wanted.release) >= LARGEST_RELEASE:
            raise InputError(
                f"The column cannot be let go at {wanted.release:g} rad: its sensor repeats itself "
                "after half a turn; give an angle within ±1.57."
            )
        if identity.drives and wanted.release is None:
            ack = tell(protocol.DRIVE, wanted.omega or 0.0, wanted.amplitude or 0.0)
            if wanted.omega:
                self.omega = ack.value / 1e6
        self.device.heard.clear()
        if wanted.release is None:
            return Stream(self.device, calibration, tell(protocol.START))
        return Stream(self.device, calibration, tell(protocol.RELEASE, wanted.release))

    def _loop(self) -> None:
        log, patience = self.log, self.settings.patience
        self._take_pending()
        heard, asked = time.monotonic(), False
        while log.state == "recording":
            try:
                data, arrival = self.port.read(0.05)
            except Unplugged:
                self._wait_for_the_rig()
                heard = time.monotonic()
                continue
            if data:
                rows = self.stream.feed(data, arrival)
                log.take(rows)
                if len(rows.values):
                    heard, asked = time.monotonic(), False
            if self.stream.timeline.restarted:
                log.state = "restarted"
            elif log.state == "recording" and time.monotonic() - heard > patience:
                # once: a rig that answers and sends no samples will not send any
                if asked or not self._heard_again():
                    log.state = "silent"
                heard, asked = time.monotonic(), True
            self._show()

    def _take_pending(self) -> None:
        for rows in self.stream.pending():
            self.log.take(rows)

    def _goes_on(self, patience: float) -> bool:
        """Asks the rig anew after an interruption; says whether it is in the same run."""
        self.device.forget()
        self.stream.interrupted()
        if self.stream.kind == "frames":
            self.device.identify(patience)
        return self.stream.same_run()

    def _heard_again(self) -> bool:
        """Asks after a rig that is silent: a cable is out further on, or it has stopped."""
        if self.stream.kind == "text":
            return False
        self.log.cause = "silent"
        try:
            goes_on = self._goes_on(self.settings.reconnect)
        except InputError:
            return False
        except Unplugged:
            return True  # seen when the port is read
        if goes_on:
            self._take_pending()
        return goes_on

    def _wait_for_the_rig(self) -> None:
        """Waits until it is plugged in again, or for as long as one may wait."""
        deadline = time.monotonic() + self.settings.reconnect
        self.log.cause = "unplugged"
        while time.monotonic() < deadline:
            self._show(unplugged=True)
            if not self.port.reopen():
                time.sleep(0.1)
                continue
            left = max(deadline - time.monotonic(), 0.1)
            try:
                goes_on = self._goes_on(min(self.settings.patience, left))
            except (Unplugged, InputError):
                # bytes of another baud, while a board starts, are no answer: ask again
                time.sleep(0.1)
                continue
            if goes_on:
                self._take_pending()
            else:
                self.log.state = "restarted"
            return
        self.log.state = "unplugged"

    def _show(self, unplugged: bool = False) -> None:
        now = time.monotonic()
        if self.progress is not None and now - self._shown >= _STATUS_PERIOD:
            self._shown = now
            self.progress(self.log.status(unplugged))

    def _end(self) -> None:
        """Stops the rig and closes the file, whatever happened."""
        log, state = self.log, self.log.state
        rest = self.stream.rest() if state in ("complete", "interrupted", "silent") else None
        if rest is not None:
            log.take(rest)
            log.state = state
        stopped = False
        if state != "unplugged":
            with suppress(Unplugged):
                stopped = self.device.stop()
        if not stopped and self.omega and self.stream.kind == "frames":
            log.notes.append(MAY_STILL_RUN)
            if log.state == "failed":  # then nobody reads the notes
                _LOG.warning(MAY_STILL_RUN)
        log.close()

    def _finished(self) -> Recorded:
        """Corrects the clock and writes down all there is to say."""
        # the rig that was recorded: at the end it need not have answered any more
        log, identity, omega = self.log, self.stream.identity, self.omega
        fit = log.clock()
        factor = correction(fit)
        if fit is not None and factor != 1.0:
            try:
                scale_time(self.path, factor)
            except OSError as fault:  # a second copy may not fit on the disk
                factor = 1.0
                log.notes.append(
                    f"The times are the rig's own: correcting them by {fit.skew:+.3g} failed "
                    f"({fault.strerror}); multiply t by 1/(1 + skew), and omega by (1 + skew)."
                )
        if omega and identity is not None and identity.drives:
            omega /= factor
        try:
            metadata = log.save(omega, fit, factor)
        except OSError as fault:
            raise InputError(
                f"Cannot write {metadata_path(self.path)}: {fault.strerror}; {self.path} is whole."
            ) from fault
        length = log.duration * factor
        return Recorded(self.path, log.state, omega or None, bool(omega), length, metadata)
