"""The messages, byte by byte, so that the two sides cannot be wrong together."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition import frames, protocol
from tp_jax.acquisition.protocol import Ack, Announced, Command, Identity


def body(wire):
    return frames.decode(wire[:-1])[:-4]


def test_a_sample():
    wire = protocol.sample(7, 0x01020304, 0x0A0B0C0D, (1, 2, 0xFFFF, 0x1234))
    assert body(wire) == bytes.fromhex("01 07 04030201 0d0c0b0a 0100 0200 ffff 3412")
    assert len(wire) == 24
    assert len(wire) * 10 * 1000 < protocol.BAUD  # 1 kHz, ten bits a byte, with room to spare


def test_numbers_wrap():
    wire = protocol.sample(256, 2**32 + 5, 2**32 + 9, (0, 0, 0, 0))
    assert struct.unpack_from("<BBII", body(wire)) == (1, 0, 5, 9)


def test_an_identity():
    identity = Identity(
        name="rig",
        wired=0b1011,
        flags=3,
        run=4,
        adc_bits=12,
        boot=0xDEADBEEF,
        rate=250.5,
        reference=3.3,
        amplitude=-0.18,
        tag=9,
    )
    assert body(protocol.message(identity)) == (
        bytes([2, 9, 1, 0b1011, 3, 4, 12, 0])
        + struct.pack("<IIIi", 0xDEADBEEF, 250500, 3300000, -180000)
        + b"rig"
    )
    assert identity.running
    assert identity.drives
    assert not identity.calibrated


def test_the_others():
    assert body(protocol.message(Command(protocol.DRIVE, 3, (13090000, 180000)))) == (
        b"\x82\x03" + struct.pack("<Ii", 13090000, 180000)
    )
    assert body(protocol.message(Command(protocol.RELEASE, 3, (-500000,)))) == (
        b"\x85\x03" + struct.pack("<i", -500000)
    )
    assert body(protocol.message(Ack(3, protocol.START, 2, 5, 2**32 + 7, -1))) == (
        bytes([4, 3, 0x83, 2, 5, 0, 0, 0]) + struct.pack("<Ii", 7, -1)
    )
    told = Announced(2, 1, (1.5, 2.5, 0, 0, 0), (0.5, 0.25, 0, 0, 0), tag=3)
    assert body(protocol.message(told)) == bytes([3, 3, 2, 1]) + struct.pack(
        "<10f", 1.5, 2.5, 0, 0, 0, 0.5, 0.25, 0, 0, 0
    )


@pytest.mark.parametrize(
    "content",
    [
        Identity("Würzburg 3", boot=1, rate=1000.0),
        Announced(1, 2, (1.0, 2.0, 3.0, 4.0, 5.0), (0.0,) * 5, 8),
        Ack(1, protocol.DRIVE, value=-5),
        *(Command(kind, 5) for kind in (protocol.IDENTIFY, protocol.START, protocol.STOP)),
        Command(protocol.DRIVE, 1, (1, -1)),
        Command(protocol.RELEASE, 255, (-3,)),
    ],
)
def test_what_is_sent_is_understood(content):
    assert protocol.parse(frames.decode(protocol.message(content)[:-1])) == content


def test_what_does_not_fit():
    with pytest.raises(ValueError, match="does not fit"):
        protocol.message(Command(protocol.DRIVE, 1, (-1, 0)))


@given(st.binary(min_size=1, max_size=100))
def test_unknown_frames_are_no_messages(content):
    frame = frames.decode(frames.encode(content)[:-1])
    message = protocol.parse(frame)  # never raises
    if message is not None and not isinstance(message, Identity):
        assert body(protocol.message(message))[:2] == content[:2]
