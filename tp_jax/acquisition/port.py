"""The serial port: opening it, reading what has come and when, opening it again after a loss."""

import os
import time
from collections.abc import Callable
from typing import Any

import serial

from tp_jax.errors import InputError

COLLECT = 0.03
"""Seconds for which bytes are let come together before they are read: few wake-ups, little work."""

_MANY = 1500
"""Bytes at once from which on there is no waiting: the system's buffer holds a few thousand."""


class Unplugged(Exception):
    """The port has gone."""


class Port:
    """A serial port.

    Attributes:
        name: as the user gave it.
        baud: bits per second.
        received: bytes so far.
    """

    def __init__(self, name: str, baud: int, clock: Callable[[], float] = time.monotonic) -> None:
        """Opens the port.

        Args:
            name: "/dev/ttyACM0", "COM3", a link to one, or a URL that pySerial knows.
            baud: bits per second.
            clock: the host's, [s].

        Raises:
            InputError: it cannot be opened.
        """
        self.name, self.baud, self.received = name, baud, 0
        self._clock = clock
        self._many = False
        try:
            self._serial = self._open()
        except (serial.SerialException, OSError, ValueError) as fault:
            raise InputError(_cannot_open(name, baud, fault)) from fault

    @property
    def usb(self) -> bool:
        """Whether a bus that is polled every millisecond lies between the rig and the host."""
        return not os.path.realpath(self.name).startswith("/dev/pts/")

    def read(self, timeout: float) -> tuple[bytes, float]:
        """What has come, and when its first byte came.

        Args:
            timeout: seconds to wait for the first byte.

        Returns:
            The bytes, none where none came; the host's clock at the first of them.

        Raises:
            Unplugged: the port has gone.
        """
        try:
            if self._serial.timeout != timeout:
                self._serial.timeout = timeout
            first = self._serial.read(1)
            arrival = self._clock()
            if not first:
                return b"", arrival
            if not self._many:
                time.sleep(COLLECT)
            more = self._serial.read(self._serial.in_waiting)
        except (serial.SerialException, OSError, TypeError) as fault:
            # TypeError: pySerial's, where another thread has closed the port
            raise Unplugged(str(fault)) from fault
        self._many = len(more) > _MANY
        self.received += 1 + len(more)
        return first + more, arrival

    def write(self, data: bytes) -> None:
        """Sends bytes.

        Raises:
            Unplugged: the port has gone.
        """
        try:
            self._serial.write(data)
        except (serial.SerialException, OSError) as fault:
            raise Unplugged(str(fault)) from fault

    def reopen(self) -> bool:
        """Tries once to open the port again; says whether it is there."""
        self.close()
        try:
            self._serial = self._open()
        except (serial.SerialException, OSError, ValueError):
            return False
        return True

    def close(self) -> None:
        """Closes the port; it may have gone."""
        try:
            self._serial.close()
        except (serial.SerialException, OSError):
            pass

    def _open(self) -> Any:  # pySerial's classes differ by system
        # the lock keeps a second recorder from taking half of the bytes
        lock: dict[str, Any] = {}
        if os.name == "posix" and "://" not in self.name:
            lock["exclusive"] = True
        return serial.serial_for_url(
            self.name, baudrate=self.baud, timeout=0.05, write_timeout=2.0, **lock
        )


def _cannot_open(name: str, baud: int, fault: Exception) -> str:
    text = str(fault).lower()
    if "lock" in text:
        return f"Cannot open the port {name}: another program has it open; close that one."
    if isinstance(fault, ValueError):
        return f"Cannot open the port {name} at {baud} baud: {fault}; give another --baud."
    if getattr(fault, "errno", None) == 13 or "permission" in text:
        return (
            f"Cannot open the port {name}: permission denied; become a member of the group that "
            "owns it, often dialout."
        )
    from serial.tools.list_ports import comports

    there = sorted(port.device for port in comports())
    found = f"the ports found are {', '.join(there)}" if there else "no serial port was found"
    return f"Cannot open the port {name}; {found}."
