"""Frames on the wire: a body with its CRC-32, COBS-encoded, ended by a zero byte.

COBS (consistent overhead byte stuffing, Cheshire and Baker 1999) takes every zero out of the body
for one byte more, so that a zero on the wire can only be the end of a frame: whatever happened
before it, the next frame is read again. The checksum is CRC-32 as in zlib, little-endian, after the
body it protects; it misses a damaged frame with a chance of 2^-32.
"""

import zlib

from cobs import cobs

END = b"\x00"
CRC_BYTES = 4

# Bytes of a body with its CRC above which COBS would need a second byte of overhead. No frame of
# the protocol is longer, so that a firmware can do with one small buffer.
LONGEST = 254
_RESIDUE = 0x2144DF1C  # CRC-32 of any bytes followed by their own: one call checks a frame


def encode(body: bytes) -> bytes:
    """The bytes on the wire for a body, the end included."""
    if not 1 <= len(body) <= LONGEST - CRC_BYTES:
        raise ValueError(
            f"A body must have 1 to {LONGEST - CRC_BYTES} bytes, but this one has {len(body)}."
        )
    return cobs.encode(body + zlib.crc32(body).to_bytes(CRC_BYTES, "little")) + END


def decode(piece: bytes) -> bytes | None:
    """The body, with its CRC, of the bytes between two ends; None where they are damaged."""
    try:
        frame = cobs.decode(piece)
    except cobs.DecodeError:
        return None
    return frame if len(frame) > CRC_BYTES and zlib.crc32(frame) == _RESIDUE else None
