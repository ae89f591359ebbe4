"""Bytes from the line to samples, messages and rows, whatever the line did to them.

A text stream has `t phi1 phi2` on a line, as a terminal shows it. Columns are separated by white
space, commas or semicolons; angles in radians, or volts where a calibration is given. Two columns
are a single pendulum's. No checksum protects a line, so a damaged digit passes for a number: the
frames of `protocol` are the better choice wherever the line is not beyond doubt.
"""

from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition import frames, protocol
from tp_jax.acquisition.protocol import SAMPLE, SAMPLE_FRAME, Message

LONGEST_PIECE = 4 * frames.LONGEST
"""Bytes without an end after which they are given up: no frame is as long."""

LONGEST_LINE = 256
"""Bytes without a line end after which they are given up."""

LARGEST = 5e6
"""A time [s] above this is none: a digit was lost on the way, or the decimal point. A counter of
32 bits of milliseconds goes up to 4.3e6 s."""

LARGEST_COUNT = 2**53
"""A time without a decimal point may be a counter's, of milliseconds or microseconds."""

LARGEST_READING = 1e4
"""A reading above this, in rad or volts, is none: 1,600 turns of a ring."""

_NONE = np.empty(0, dtype=SAMPLE_FRAME)
_SEPARATORS = bytes.maketrans(b",;\t", b"   ")


@dataclass(frozen=True)
class Batch:
    """The content of some bytes.

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
    """Takes the bytes of frames as they come, in pieces of any length; never raises.

    Attributes:
        good: frames that passed.
        corrupt: pieces between two ends that were no frame. A damaged frame is one such piece,
            two that lost the end between them are one as well, and one that got a zero in its
            midst is two: samples lost are counted by their sequence numbers (`timeline`).
        unknown: frames that passed and are of no kind known to this version.
    """

    def __init__(self) -> None:
        self.good = self.corrupt = self.unknown = 0
        self.clear()

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

        samples, messages, sharp = [], [], False
        pieces = [
            piece for piece in pieces if piece
        ]  # a sender may clear the line by ends in a row
        for i, piece in enumerate(pieces):
            frame = frames.decode(piece)
            if frame is None:
                self.corrupt += 1
            elif frame[0] == SAMPLE and len(frame) == SAMPLE_FRAME.itemsize:
                samples.append(frame)
                sharp = sharp or i == 0
            elif (message := protocol.parse(frame)) is not None:
                messages.append(message)
            else:
                self.unknown += 1
        self.good += len(samples) + len(messages)
        array = np.frombuffer(b"".join(samples), dtype=SAMPLE_FRAME) if samples else _NONE
        return Batch(array, tuple(messages), sharp)

    def clear(self) -> None:
        """Forgets a frame begun: the line was interrupted."""
        self._rest = b""
        self._lost_begin = False


class TextParser:
    """Takes the bytes of lines as they come, in pieces of any length; never raises.

    Attributes:
        columns: 3, or 2 for a single pendulum; None until a line has told.
        good: lines of numbers.
        corrupt: lines of anything else; blank ones and those that begin with `#` do not count.
        sharp: whether the first line that the last bytes completed is the first of its rows.
    """

    unknown = 0

    def __init__(self) -> None:
        self.columns: int | None = None
        self.good = self.corrupt = 0
        self.sharp = False
        self.clear()

    def feed(self, data: bytes) -> np.ndarray:
        """(n, columns) numbers of the lines that these bytes complete; (0, 0) before the first."""
        *lines, rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        if len(rest) > LONGEST_LINE:
            self._skip_first, rest = True, b""
            self.corrupt += 1
        self._rest = rest
        if self._skip_first and lines:
            del lines[0]  # begun before we listened
            self._skip_first = False
        rows = []
        self.sharp = bool(lines) and numbers(lines[0]) is not None
        for line in lines:
            row = numbers(line)
            if row is not None and len(row) == (self.columns or len(row)):
                self.columns = len(row)
                rows.append(row)
            else:
                self.corrupt += bool(line.strip()) and not line.lstrip().startswith(b"#")
        self.good += len(rows)
        return np.array(rows, dtype=float).reshape(len(rows), self.columns or 0)

    def clear(self) -> None:
        """Forgets a line begun: the next bytes start somewhere inside another."""
        self._rest = b""
        self._skip_first = True


def numbers(line: bytes) -> list[float] | None:
    """The time and the one or two readings of a line; None where it is anything else."""
    cells = line.translate(_SEPARATORS).split()
    if not 2 <= len(cells) <= 3 or b"_" in line:
        return None
    try:
        time, *readings = (float(cell) for cell in cells)
    except ValueError:
        return None
    largest = LARGEST_COUNT if cells[0].lstrip(b"+-").isdigit() else LARGEST
    # a NaN is below nothing
    plausible = abs(time) <= largest and all(abs(x) <= LARGEST_READING for x in readings)
    return [time, *readings] if plausible else None
