"""Bytes from the line to samples, messages and rows, whatever the line did to them.

A text stream has `t phi1 phi2` on a line, separated by white space, commas or semicolons; angles in
radians, or volts where a calibration is given. Two columns are a single pendulum's. No checksum
protects a line, so a damaged digit passes for a number: frames are the better choice wherever the
line is not beyond doubt.
"""

from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition import frames, protocol
from tp_jax.acquisition.protocol import SAMPLE, SAMPLE_FRAME, Message

# bytes without an end after which they are given up: no frame and no line is as long
LONGEST_PIECE, LONGEST_LINE = 4 * frames.LONGEST, 256
# A time [s] above this has lost a digit on the way, or its decimal point. A counter of 32 bits of
# milliseconds goes up to 4.3e6 s; without a decimal point it may be of microseconds.
LARGEST, LARGEST_COUNT = 5e6, 2**53
LARGEST_READING = 1e4  # in rad or volts; 1,600 turns of a ring

_NONE = np.empty(0, dtype=SAMPLE_FRAME)
_SEPARATORS = bytes.maketrans(b",;\t", b"   ")


@dataclass(frozen=True)
class Batch:
    """The frames in some bytes."""

    samples: np.ndarray  # (n,) of `SAMPLE_FRAME`, in the order they came
    messages: tuple[Message, ...] = ()  # all others
    sharp: bool = False  # the first frame is the first of `samples`: the arrival is its own


class _Parser:
    """Takes the bytes as they come, in pieces of any length; never raises."""

    end, longest = frames.END, LONGEST_PIECE
    amidst = False  # True: the first piece may have begun before its first byte

    def __init__(self) -> None:
        self.good = 0  # frames that passed, or lines of numbers
        # Pieces that were neither. Two frames that lost the end between them are one, a frame that
        # got a zero in its midst is two: samples lost are counted by `timeline`.
        self.corrupt = 0
        self.unknown = 0  # frames that passed and are of no kind known to this version
        self.clear()

    def clear(self) -> None:
        """Forgets a piece begun: the line was interrupted."""
        self._rest, self._skip_first = b"", self.amidst

    def _pieces(self, data: bytes) -> list[bytes]:
        *pieces, rest = (self._rest + data).split(self.end)
        if self._skip_first and pieces:
            del pieces[0]
            self._skip_first = False
        if len(rest) > self.longest:
            self.corrupt += not self._skip_first
            self._skip_first, rest = True, b""
        self._rest = rest
        return pieces


class FrameParser(_Parser):
    """Frames out of bytes."""

    def feed(self, data: bytes) -> Batch:
        """The frames that these bytes complete."""
        samples, messages, sharp = [], [], False
        pieces = [piece for piece in self._pieces(data) if piece]  # ends in a row clear the line
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


class TextParser(_Parser):
    """Lines of numbers out of bytes. Blank lines and those that begin with `#` do not count."""

    end, longest, amidst = b"\n", LONGEST_LINE, True
    columns: int | None = None  # 3, or 2 for a single pendulum; None until a line has told
    sharp = False  # the first line of the last bytes is the first of their rows

    def feed(self, data: bytes) -> np.ndarray:
        """(n, columns) numbers of the lines that these bytes complete; (0, 0) before the first."""
        lines = self._pieces(data.replace(b"\r", b"\n"))
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
