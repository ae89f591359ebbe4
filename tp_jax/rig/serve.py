"""The virtual rig on a pseudo-terminal, in real time or faster, with a line as good as wanted."""

import os
import select
import shutil
import signal
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from tp_jax.errors import InputError
from tp_jax.rig.emulator import Firmware

BUFFER = 1 << 16
"""Bytes that are kept for a host that does not read; what comes then is lost, as on a board."""

_AT_ONCE = 2048  # bytes produced ahead where nothing paces the rig but the host
_TICK = 1e-3  # s


class Line:
    """A serial line that damages and loses bytes.

    Attributes:
        corrupt: fraction of bytes of which some bits flip.
        drop: fraction of bytes that never arrive.
    """

    def __init__(self, corrupt: float = 0.0, drop: float = 0.0, seed: int = 0) -> None:
        self.corrupt, self.drop = corrupt, drop
        self._rng = np.random.default_rng([seed, 0x11E])

    def carry(self, data: bytes) -> bytes:
        """Returns what arrives of some bytes."""
        if not data or not (self.corrupt or self.drop):
            return data
        array = np.frombuffer(data, dtype=np.uint8).copy()
        hit = self._rng.random(array.size) < self.corrupt
        array[hit] ^= self._rng.integers(1, 256, int(hit.sum()), dtype=np.uint8)
        return array[self._rng.random(array.size) >= self.drop].tobytes()


class Terminal:
    """A pseudo-terminal behind a link that stays the same when it is plugged out and in again.

    Attributes:
        path: the link, the port's name for the host.
        master: the rig's end; None while unplugged.
    """

    def __init__(self) -> None:
        """Plugs in."""
        if not hasattr(os, "openpty"):
            raise InputError(
                "This system has no pseudo-terminals, which the virtual rig needs; use Linux or "
                "macOS."
            )
        try:
            self._folder = Path(tempfile.mkdtemp(prefix="tp-jax-rig-"))
        except FileNotFoundError as fault:  # it tries all, and names them
            raise InputError(
                "No folder for temporary files can be written to; make room, or set TMPDIR."
            ) from fault
        self.path = self._folder / "port"
        self.master: int | None = None
        self._slave = -1
        self.plug()

    def plug(self) -> None:
        """Makes a pseudo-terminal and lets the link point to it."""
        import tty

        if self.master is not None:
            return
        # our own hold on the host's end keeps it alive while no host has it open
        master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(master, False)
        link = self._folder / "new"
        link.symlink_to(os.ttyname(self._slave))
        os.replace(link, self.path)
        self.master = master

    def unplug(self) -> None:
        """Takes the pseudo-terminal away: a host that has it open reads an error."""
        if self.master is None:
            return
        self.path.unlink(missing_ok=True)
        os.close(self.master)
        os.close(self._slave)
        self.master = None

    def close(self) -> None:
        """Unplugs for good."""
        self.unplug()
        shutil.rmtree(self._folder, ignore_errors=True)


class Emulator:
    """The virtual rig at work.

    Attributes:
        firmware: its program.
        terminal: its port.
        speed: seconds of the rig's time in a second; None: as fast as the host reads.
        overflowed: bytes lost since the host did not read.
    """

    def __init__(
        self,
        firmware: Firmware,
        *,
        speed: float | None = 1.0,
        line: Line | None = None,
        unplug: tuple[float, float] | None = None,
    ) -> None:
        """
        Args:
            firmware: the program.
            speed: see above.
            line: to the host; None: a perfect one.
            unplug: (at, duration) of an unplugging, rig's seconds of the first run.
        """
        self.firmware, self.speed = firmware, speed
        self.terminal = Terminal()
        self.overflowed = 0
        self._line = Line() if line is None else line
        self._unplug = unplug
        self._want_plugged = True
        self._queue = bytearray()
        self._begin = time.monotonic()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def port(self) -> str:
        """The port's name for the host."""
        return str(self.terminal.path)

    def __enter__(self) -> "Emulator":
        """Serves in a thread of its own."""
        self._thread = threading.Thread(target=self.serve, name="tp-jax-rig", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def unplug(self) -> None:
        """Takes the port away; it happens within some milliseconds."""
        self._want_plugged = False

    def plug(self) -> None:
        """Gives it back."""
        self._want_plugged = True

    def serve(self, watch: int | None = None) -> None:
        """Serves until told to stop.

        Args:
            watch: a file descriptor; its end is the end of serving.
        """
        try:
            while not self._stop.is_set():
                self._plug_or_unplug()
                self._sample()
                self._send()
                if self._wait(watch):
                    return
        finally:
            self.terminal.close()

    def _now(self) -> int:
        """The firmware's clock [µs]."""
        firmware = self.firmware
        if self.speed is None:
            return firmware.due or 0
        true = (time.monotonic() - self._begin) * self.speed
        return int(true * (1.0 + firmware.skew) * 1e6)

    def _plug_or_unplug(self) -> None:
        if self._unplug is not None:
            at, duration = self._unplug
            into = self.firmware.sent / self.firmware.rate
            self._want_plugged = not at <= into < at + duration
            if into >= at + duration:
                self._unplug = None
        if self._want_plugged and self.terminal.master is None:
            self.terminal.plug()
            self.firmware.plugged()
        elif not self._want_plugged and self.terminal.master is not None:
            self.terminal.unplug()
            self._queue.clear()

    def _plugged_for_too_long(self) -> bool:
        """True if the time to be unplugged has come."""
        if self._unplug is None or self.terminal.master is None:
            return False
        return self.firmware.sent / self.firmware.rate >= self._unplug[0]

    def _sample(self) -> None:
        """Takes the samples that are due."""
        firmware, now = self.firmware, self._now()
        produced = bytearray()
        while firmware.due is not None:
            if self.speed is None:
                if len(self._queue) + len(produced) >= _AT_ONCE:
                    break
            elif firmware.due > now:
                break
            produced += firmware.sample()
            if len(produced) >= _AT_ONCE:
                break  # so that a slow simulator still hears and sends
            if self._plugged_for_too_long():
                break  # a busy computer takes many samples at once, but none of them comes after
        self._put(bytes(produced))

    def _put(self, data: bytes) -> None:
        if self.terminal.master is None or not data:
            return
        arriving = self._line.carry(data)
        if len(self._queue) + len(arriving) > BUFFER:
            self.overflowed += len(arriving)
            return
        self._queue += arriving

    def _send(self) -> None:
        if self._queue and self.terminal.master is not None:
            try:
                done = os.write(self.terminal.master, self._queue)
            except (BlockingIOError, OSError):  # full; or nobody there any more
                return
            del self._queue[:done]

    def _wait(self, watch: int | None) -> bool:
        """Waits until there is something to do; True if it is to end."""
        master = self.terminal.master
        ends = [fd for fd in (master, watch) if fd is not None]
        full = [master] if self._queue and master is not None else []
        readable, _, _ = select.select(ends, full, [], self._pause())
        if watch in readable and not os.read(watch, 4096):  # type: ignore[arg-type]
            return True
        if master is not None and master in readable:
            try:
                heard = os.read(master, 4096)
            except OSError:
                heard = b""
            if heard:
                self._put(self.firmware.hear(self._line.carry(heard), self._now()))
        return False

    def _pause(self) -> float:
        """Seconds until the next sample is due."""
        due = self.firmware.due
        if due is None:
            return 0.02
        if self.speed is None:
            return 0.0 if len(self._queue) < _AT_ONCE else 0.02
        return max((due - self._now()) / 1e6 / self.speed, 0.0 if self.speed < 2.0 else _TICK)


def serve_until_interrupted(emulator: Emulator, watch: int | None = None) -> None:
    """Serves until Ctrl-C or a request to end, and leaves nothing behind."""

    def end(*_: object) -> None:
        emulator._stop.set()

    before = signal.signal(signal.SIGTERM, end)
    try:
        emulator.serve(watch)
    except KeyboardInterrupt:
        pass
    finally:
        signal.signal(signal.SIGTERM, before)
