"""The messages between a rig and its host, version 1.

A message is the body of a frame (see `frames`). Its first byte says what it is. All numbers are
little-endian; angles and frequencies cross the wire as whole micro-units, so that 13.09 rad/s
means the same on either side.

From the rig:

    SAMPLE      type u8 = 1, run u8, sequence u32, time u32 [µs], readings 4 × u16
    IDENTITY    type u8 = 2, tag u8, protocol u8, wired u8, flags u8, run u8, adc_bits u8, 0 u8,
                boot u32, rate u32 [mHz], reference u32 [µV], amplitude i32 [µrad], name UTF-8
    CALIBRATION type u8 = 3, tag u8, sensor u8 (1, 2), law u8 (0 line, 1 sine, 2 sine_cosine),
                values 5 × f32, standard errors 5 × f32: offset [V], gain [V/rad],
                cosine_offset [V], cosine_gain [V/rad], zero [rad]
    ACK         type u8 = 4, tag u8, command u8, status u8, run u8, 0 u8 × 3,
                time u32 [µs], value i32

From the host:

    IDENTIFY    type u8 = 0x81, tag u8
    DRIVE       type u8 = 0x82, tag u8, omega u32 [µrad/s], amplitude i32 [µrad], 0: as it is
    START       type u8 = 0x83, tag u8
    STOP        type u8 = 0x84, tag u8
    RELEASE     type u8 = 0x85, tag u8, angle i32 [µrad]

How they are used:

- A rig sends no samples until START or RELEASE, and goes on until STOP, whether or not anybody
  listens. START drives the motor from rest, phase 0, at what DRIVE set last (omega 0: the motor
  stands at neutral). RELEASE puts the motor to neutral and lets the column go at the angle, or
  leaves that to a hand.
- Every command is answered by an ACK with its tag, IDENTIFY by an IDENTITY and the CALIBRATIONs.
  A command that comes again with the same tag is answered again, but not carried out again: an
  answer may have been lost.
- `run` counts the runs since power-up, modulo 256; samples carry it, so that what is left of an
  older run is not taken for this one. `sequence` counts the samples of a run from 0, lost ones
  included. `time` is the rig's clock at the sample; it wraps after 71.6 minutes, and the sequence
  number tells how often. The ACK of START and RELEASE has the time of the run's begin, which is
  t = 0 of the recording, and of sample 0.
- An ACK's `value` is what the rig made of the value commanded (DRIVE: omega, which a timer can
  only approach; RELEASE: the angle), in the same unit.
- `readings` are the ADC's counts, scaled to 16 bits, of the bridges sine 1, cosine 1, sine 2,
  cosine 2; `wired` says by bits 0 to 3 which of them there are, others read 0. Counts times
  reference / 65535 are volts.
- `flags`: bit 0, a run is on; bit 1, the rig has a motor to command; bit 2, it announces a
  calibration for each sensor that is wired.
- `boot` is a number that differs after every power-up: a host that has lost the rig for a while
  sees by it whether the run can have gone on.

A sample is 24 bytes on the wire: 1 kHz is 24 kB/s, half of what 460800 baud carry. One sample to
a frame, since a line that damages one byte in a hundred still lets four of five such frames pass.
"""

import struct
from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition.frames import CRC_BYTES, encode

VERSION = 1
BAUD = 460800

SAMPLE, IDENTITY, CALIBRATION, ACK = 1, 2, 3, 4
IDENTIFY, DRIVE, START, STOP, RELEASE = 0x81, 0x82, 0x83, 0x84, 0x85
COMMANDS = {
    IDENTIFY: "identify",
    DRIVE: "drive",
    START: "start",
    STOP: "stop",
    RELEASE: "release",
}

OK, UNKNOWN_COMMAND, BAD_VALUE, NOT_ABLE = 0, 1, 2, 3
STATUS = {
    OK: "done",
    UNKNOWN_COMMAND: "does not know this command",
    BAD_VALUE: "cannot do this value",
    NOT_ABLE: "is not able to do this",
}

SINE1, COSINE1, SINE2, COSINE2 = 1, 2, 4, 8
"""Bits of `wired`."""

BRIDGES = ("sine1", "cosine1", "sine2", "cosine2")
"""Their names, by bit."""

RUNNING, DRIVES, CALIBRATED = 1, 2, 4
"""Bits of an identity's flags: a run is on; the rig has a motor to command; it announces
calibrations."""

LAWS = ("line", "sine", "sine_cosine")
"""By their number in a CALIBRATION; see `calibration`."""

FULL_SCALE = 65535
"""Counts of a reading at the reference voltage."""

SAMPLE_FRAME = np.dtype(
    [
        ("type", "u1"),
        ("run", "u1"),
        ("sequence", "<u4"),
        ("time", "<u4"),
        ("readings", "<u2", (4,)),
        ("crc", "<u4"),
    ]
)
"""A sample's body with its CRC."""

_SAMPLE = struct.Struct("<BBII4H")
_IDENTITY = struct.Struct("<8B3Ii")
_CALIBRATION = struct.Struct("<4B10f")
_ACK = struct.Struct("<5B3xIi")
_COMMANDS = {
    IDENTIFY: struct.Struct("<BB"),
    DRIVE: struct.Struct("<BBIi"),
    START: struct.Struct("<BB"),
    STOP: struct.Struct("<BB"),
    RELEASE: struct.Struct("<BBi"),
}


@dataclass(frozen=True)
class Identity:
    """Who answers; attributes as in the module's docstring, in SI units.

    Attributes:
        rate: samples per second [Hz].
        reference: the ADC's full scale [V].
        amplitude: of the drive [rad]; 0 where the rig does not know it.
    """

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
        """Whether a run is on."""
        return bool(self.flags & RUNNING)

    @property
    def calibrated(self) -> bool:
        """Whether it announces calibrations."""
        return bool(self.flags & CALIBRATED)

    @property
    def drives(self) -> bool:
        """Whether there is a motor to command."""
        return bool(self.flags & DRIVES)


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
    """What the host asks for; values in micro-units, as many as the command has."""

    command: int
    tag: int
    values: tuple[int, ...] = ()


Message = Identity | Announced | Ack | Command


def micro(value: float) -> int:
    """A value in whole micro-units."""
    return round(value * 1e6)


# To the wire ---------------------------------------------------------------------------------


def sample(run: int, sequence: int, time: int, readings: tuple[int, int, int, int]) -> bytes:
    """The wire bytes of a SAMPLE; sequence and time [µs] are taken modulo 2^32."""
    return encode(
        _SAMPLE.pack(SAMPLE, run & 0xFF, sequence & 0xFFFFFFFF, time & 0xFFFFFFFF, *readings)
    )


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
    if isinstance(content, Identity):
        head = _IDENTITY.pack(
            IDENTITY,
            content.tag,
            content.protocol,
            content.wired,
            content.flags,
            content.run,
            content.adc_bits,
            0,
            content.boot,
            round(content.rate * 1e3),
            micro(content.reference),
            micro(content.amplitude),
        )
        return head + content.name.encode()[:200]
    if isinstance(content, Announced):
        return _CALIBRATION.pack(
            CALIBRATION, content.tag, content.sensor, content.law, *content.values, *content.errors
        )
    if isinstance(content, Ack):
        return _ACK.pack(
            ACK,
            content.tag,
            content.command,
            content.status,
            content.run,
            content.time & 0xFFFFFFFF,
            content.value,
        )
    return _COMMANDS[content.command].pack(content.command, content.tag, *content.values)


# From the wire -------------------------------------------------------------------------------


def parse(frame: bytes) -> Message | None:
    """What a frame other than a sample says.

    Args:
        frame: body with CRC, as `frames.decode` returns it.

    Returns:
        The message; None for a kind, or a length, that this version does not know.
    """
    body = frame[:-CRC_BYTES]
    kind = body[0]
    if kind == IDENTITY and len(body) >= _IDENTITY.size:
        _, tag, protocol, wired, flags, run, bits, _, boot, rate, reference, amplitude = (
            _IDENTITY.unpack_from(body)
        )
        return Identity(
            name=body[_IDENTITY.size :].decode(errors="replace"),
            protocol=protocol,
            wired=wired,
            flags=flags,
            run=run,
            adc_bits=bits,
            boot=boot,
            rate=rate / 1e3,
            reference=reference / 1e6,
            amplitude=amplitude / 1e6,
            tag=tag,
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
