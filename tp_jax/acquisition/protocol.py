"""The messages between a rig and its host, version 1; firmware/README.md has them byte by byte.

A message is the body of a frame (see `frames`). All numbers are little-endian; angles and
frequencies cross the wire as whole micro-units, so that 13.09 rad/s means the same on either side.
"""

import struct
from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition.frames import CRC_BYTES, encode

VERSION = 1
BAUD = 460800

SAMPLE, IDENTITY, CALIBRATION, ACK = 1, 2, 3, 4
IDENTIFY, DRIVE, START, STOP, RELEASE = 0x81, 0x82, 0x83, 0x84, 0x85
COMMANDS = dict(
    zip(range(IDENTIFY, 0x86), "identify drive start stop release".split(), strict=True)
)

OK, UNKNOWN_COMMAND, BAD_VALUE, NOT_ABLE = range(4)
STATUS = ("done", "does not know this command", "cannot do this value", "is not able to do this")

BRIDGES = ("sine1", "cosine1", "sine2", "cosine2")
SINE1, COSINE1, SINE2, COSINE2 = 1, 2, 4, 8  # bits of `wired`
# bits of `flags`: a run is on; there is a motor to command; calibrations are announced
RUNNING, DRIVES, CALIBRATED = 1, 2, 4
LAWS = ("line", "sine", "sine_cosine")  # of `recordings.calibration`, by number
FULL_SCALE = 65535  # counts of a reading at the reference voltage

SAMPLE_FRAME = np.dtype(
    {
        "names": ["type", "run", "sequence", "time", "readings", "crc"],
        "formats": ["u1", "u1", "<u4", "<u4", "(4,)<u2", "<u4"],
    }
)
"""A sample's body with its CRC."""

_SAMPLE = struct.Struct("<BBII4H")
_IDENTITY = struct.Struct("<8B3Ii")
_CALIBRATION = struct.Struct("<4B10f")
_ACK = struct.Struct("<5B3xIi")
_COMMANDS = {kind: struct.Struct("<BB") for kind in COMMANDS}
_COMMANDS |= {DRIVE: struct.Struct("<BBIi"), RELEASE: struct.Struct("<BBi")}


@dataclass(frozen=True)
class Identity:
    """The answer to IDENTIFY; rate [Hz], reference [V], amplitude [rad], 0 where unknown."""

    name: str
    protocol: int = VERSION
    wired: int = SINE1 | SINE2
    flags: int = 0
    run: int = 0
    adc_bits: int = 16
    boot: int = 0
    rate: float = 1000.0
    reference: float = 3.3
    amplitude: float = 0.0
    tag: int = 0

    @property
    def running(self) -> bool:
        return bool(self.flags & RUNNING)

    @property
    def drives(self) -> bool:
        return bool(self.flags & DRIVES)

    @property
    def calibrated(self) -> bool:
        return bool(self.flags & CALIBRATED)


@dataclass(frozen=True)
class Announced:
    """A calibration that the rig announces for a sensor (1 or 2): five values, five errors."""

    sensor: int
    law: int
    values: tuple[float, ...]
    errors: tuple[float, ...]
    tag: int = 0


@dataclass(frozen=True)
class Ack:
    """The answer to a command; time [µs] as it stands on the wire, value in micro-units."""

    tag: int
    command: int
    status: int = OK
    run: int = 0
    time: int = 0
    value: int = 0


@dataclass(frozen=True)
class Command:
    """A wish of the host; values in micro-units, as many as the command has."""

    command: int
    tag: int
    values: tuple[int, ...] = ()


Message = Identity | Announced | Ack | Command


def micro(value: float) -> int:
    """A value in whole micro-units."""
    return round(value * 1e6)


def sample(run: int, sequence: int, time: int, readings: tuple[int, int, int, int]) -> bytes:
    """The wire bytes of a SAMPLE; sequence and time [µs] are taken modulo 2^32."""
    numbers = (run & 0xFF, sequence & 0xFFFFFFFF, time & 0xFFFFFFFF)
    return encode(_SAMPLE.pack(SAMPLE, *numbers, *readings))


def message(content: Message) -> bytes:
    """The wire bytes of any other message.

    Raises:
        ValueError: a value does not fit its field.
    """
    try:
        return encode(_body(content))
    except struct.error as fault:
        raise ValueError(f"{content} does not fit its frame: {fault}.") from None


def _body(content: Message) -> bytes:
    m = content
    if isinstance(m, Identity):
        small = (m.tag, m.protocol, m.wired, m.flags, m.run, m.adc_bits, 0)
        large = (m.boot, round(m.rate * 1e3), micro(m.reference), micro(m.amplitude))
        return _IDENTITY.pack(IDENTITY, *small, *large) + m.name.encode()[:200]
    if isinstance(m, Announced):
        return _CALIBRATION.pack(CALIBRATION, m.tag, m.sensor, m.law, *m.values, *m.errors)
    if isinstance(m, Ack):
        return _ACK.pack(ACK, m.tag, m.command, m.status, m.run, m.time & 0xFFFFFFFF, m.value)
    return _COMMANDS[m.command].pack(m.command, m.tag, *m.values)


def parse(frame: bytes) -> Message | None:
    """The message in a frame, with its CRC, other than a sample's.

    None for a kind, or a length, that this version does not know.
    """
    body = frame[:-CRC_BYTES]
    kind = body[0]
    if kind == IDENTITY and len(body) >= _IDENTITY.size:
        _, tag, version, wired, flags, run, bits, _, boot, *scaled = _IDENTITY.unpack_from(body)
        name = body[_IDENTITY.size :].decode(errors="replace")
        rate, reference, amplitude = scaled[0] / 1e3, scaled[1] / 1e6, scaled[2] / 1e6
        return Identity(
            name, version, wired, flags, run, bits, boot, rate, reference, amplitude, tag
        )
    if kind == CALIBRATION and len(body) == _CALIBRATION.size:
        _, tag, sensor, law, *numbers = _CALIBRATION.unpack(body)
        return Announced(sensor, law, tuple(numbers[:5]), tuple(numbers[5:]), tag)
    if kind == ACK and len(body) == _ACK.size:
        return Ack(*_ACK.unpack(body)[1:])
    layout = _COMMANDS.get(kind)
    if layout is not None and len(body) == layout.size:
        command, tag, *values = layout.unpack(body)
        return Command(command, tag, tuple(values))
    return None
