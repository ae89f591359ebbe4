"""Bytes from the line to samples and messages, whatever the line did to them."""

from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition import frames, protocol
from tp_jax.acquisition.protocol import SAMPLE, SAMPLE_FRAME, Message

_SAMPLE_BYTES = SAMPLE_FRAME.itemsize
_NONE = np.empty(0, dtype=SAMPLE_FRAME)

LONGEST_PIECE = 4 * frames.LONGEST
"""Bytes without an end after which they are given up: no frame is as long."""


@dataclass(frozen=True)
class Batch:
    """What some bytes held.

    Attributes:
        samples: (n,) of `SAMPLE_FRAME`, in the order they came.
        messages: all others.
        sharp: whether the first frame that was completed is the first of `samples`, so that the
            arrival of the bytes is its own.
    """

    samples: np.ndarray
    messages: tuple[Message, ...] = ()
    sharp: bool = False


class FrameParser:
    """Takes the bytes as they come, in pieces of any length.

    Never raises, and keeps no more than `LONGEST_PIECE` bytes between calls.

    Attributes:
        good: frames that passed.
        corrupt: pieces between two ends that were no frame. A damaged frame is one such piece,
            two that lost the end between them are one as well, and one that got a zero in its
            midst is two: samples lost are counted by their sequence numbers (`timeline`).
        unknown: frames that passed and are of no kind known to this version.
    """

    def __init__(self) -> None:
        self.good = 0
        self.corrupt = 0
        self.unknown = 0
        self._rest = b""
        self._lost_begin = False

    def feed(self, data: bytes) -> Batch:
        """The frames that these bytes complete."""
        *pieces, rest = (self._rest + data).split(frames.END)
        if self._lost_begin and pieces:
            self.corrupt += 1
            self._lost_begin = False
            del pieces[0]  # the end of what was given up
        if len(rest) > LONGEST_PIECE:
            self._lost_begin, rest = True, b""
        self._rest = rest

        samples, messages, sharp, first = [], [], False, True
        for piece in pieces:
            if not piece:
                continue  # ends in a row: a sender may clear the line by them
            frame = frames.decode(piece)
            if frame is None:
                self.corrupt += 1
            elif frame[0] == SAMPLE and len(frame) == _SAMPLE_BYTES:
                samples.append(frame)
                sharp = sharp or first
            else:
                message = protocol.parse(frame)
                if message is None:
                    self.unknown += 1
                else:
                    messages.append(message)
            first = False
        self.good += len(samples) + len(messages)
        array = np.frombuffer(b"".join(samples), dtype=SAMPLE_FRAME) if samples else _NONE
        return Batch(array, tuple(messages), sharp)

    def clear(self) -> None:
        """Forgets a frame begun: the line was interrupted."""
        self._rest = b""
        self._lost_begin = False
