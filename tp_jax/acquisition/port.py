"""The serial port: opening it, reading with the time of arrival, opening it again after a loss."""

import os
import time
from collections.abc import Callable
from typing import Any

import serial

try:
    from termios import error as TermiosError
except ImportError:  # Windows
    TermiosError = OSError

from tp_jax.errors import InputError

# Bytes are let come together for so many seconds before they are read: few wake-ups, little work.
# After so many at once there is no waiting: the system's buffer holds a few thousand.
COLLECT, _MANY = 0.03, 1500

_FAULTS = (serial.SerialException, OSError, TermiosError)  # the last of a port that is hung up


class Unplugged(Exception):
    """The port has gone: any reading or writing of it may say so."""


class Port:
    """A serial port; `received` counts its bytes."""

    def __init__(self, name: str, baud: int, clock: Callable[[], float] = time.monotonic) -> None:
        """Opens "/dev/ttyACM0", "COM3", a link to one, or a URL that pySerial knows.

        Args:
            name: of the port; InputError where it cannot be opened.
            baud: bits per second.
            clock: the host's, [s].
        """
        self.name, self.baud, self.received = name, baud, 0
        self._clock = clock
        self._many = False
        try:
            self._serial = self._open()
        except (*_FAULTS, ValueError) as fault:
            raise InputError(_cannot_open(name, baud, fault)) from fault

    @property
    def usb(self) -> bool:
        """True where a bus that is polled every millisecond lies between the rig and the host."""
        return not os.path.realpath(self.name).startswith("/dev/pts/")

    def read(self, timeout: float) -> tuple[bytes, float]:
        """The bytes that come within so many seconds, and the host's clock at the first of them."""
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
        except (*_FAULTS, TypeError) as fault:  # pySerial's, where another thread has closed it
            raise Unplugged(str(fault)) from fault
        self._many = len(more) > _MANY
        self.received += 1 + len(more)
        return first + more, arrival

    def write(self, data: bytes) -> None:
        """Sends bytes."""
        try:
            self._serial.write(data)
        except _FAULTS as fault:
            raise Unplugged(str(fault)) from fault

    def reopen(self) -> bool:
        """Tries once to open the port again; says whether it is there."""
        self.close()
        try:
            self._serial = self._open()
        except (*_FAULTS, ValueError):
            return False
        return True

    def close(self) -> None:
        """Closes the port; it may have gone."""
        try:
            self._serial.close()
        except _FAULTS:
            pass

    def _open(self) -> Any:  # pySerial's classes differ by system
        # the lock keeps a second recorder from taking half of the bytes
        own = os.name == "posix" and "://" not in self.name
        lock: dict[str, Any] = {"exclusive": True} if own else {}
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

    there = ", ".join(sorted(port.device for port in comports()))
    found = f"the ports found are {there}" if there else "no serial port was found"
    return f"Cannot open the port {name}; {found}."
