"""COBS and CRC-32 on the wire."""

import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tp_jax.acquisition import frames


def test_a_frame_byte_by_byte():
    # CRC-32 of "123456789" is the standard check value 0xCBF43926
    wire = frames.encode(b"123456789")
    assert wire == b"\x0e123456789\x26\x39\xf4\xcb\x00"
    # a zero in the body becomes the distance to the next
    body = b"\x01\x00\x02"
    crc = zlib.crc32(body).to_bytes(4, "little")
    assert frames.encode(body) == b"\x02\x01\x06\x02" + crc + b"\x00"


@given(st.binary(min_size=1, max_size=frames.LONGEST - frames.CRC_BYTES))
def test_what_is_sent_is_received(body):
    wire = frames.encode(body)
    assert wire.count(b"\0") == 1
    assert wire.endswith(b"\0")
    assert len(wire) == len(body) + 6  # one byte of overhead, the CRC, the end
    assert frames.decode(wire[:-1])[:-4] == body


@given(st.binary(min_size=1, max_size=40), st.data())
def test_one_damaged_byte_is_always_seen(body, data):
    wire = bytearray(frames.encode(body)[:-1])
    at = data.draw(st.integers(0, len(wire) - 1))
    wire[at] ^= data.draw(st.integers(1, 255))
    assert frames.decode(bytes(wire)) is None


@given(st.binary(max_size=300))
def test_anything_else_is_no_frame(junk):
    assert frames.decode(junk) is None


@pytest.mark.parametrize("length", [0, 251])
def test_bodies_that_do_not_fit(length):
    with pytest.raises(ValueError, match="1 to 250 bytes"):
        frames.encode(bytes(length))
