"""The plain-text stream: `t phi1 phi2` on a line, as a terminal shows it.

Columns are separated by white space, commas or semicolons; t in seconds, angles in radians, or,
where a calibration is given, volts. Two columns are a single pendulum's. A line is nothing else:
no checksum protects it, so a damaged digit passes for a number. The frames of `protocol` are the
better choice wherever the line is not beyond doubt.
"""

import numpy as np

LONGEST_LINE = 256
"""Bytes without a line end after which they are given up."""

LARGEST = 1e6
"""A time [s] above this is none: a digit was lost on the way, or the decimal point."""

LARGEST_READING = 1e4
"""A reading above this, in rad or volts, is none: 1,600 turns of a ring."""

_SEPARATORS = bytes.maketrans(b",;\t", b"   ")


class TextParser:
    """Takes the bytes as they come; never raises.

    Attributes:
        columns: 3, or 2 for a single pendulum; None until a line has told.
        good: lines of numbers.
        corrupt: lines of anything else; blank ones and those that begin with `#` do not count.
        sharp: whether the first line that the last bytes completed is the first of its rows.
    """

    def __init__(self, columns: int | None = None) -> None:
        self.columns = columns
        self.good = 0
        self.corrupt = 0
        self.sharp = False
        self._rest = b""
        self._skip_first = True

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
            if row is None:
                self.corrupt += bool(line.strip()) and not line.lstrip().startswith(b"#")
                continue
            if self.columns is None:
                self.columns = len(row)
            if len(row) == self.columns:
                rows.append(row)
            else:
                self.corrupt += 1
        self.good += len(rows)
        return np.array(rows, dtype=float).reshape(len(rows), self.columns or 0)

    def clear(self) -> None:
        """Forgets a line begun: what follows starts somewhere inside another."""
        self._rest = b""
        self._skip_first = True


def numbers(line: bytes) -> list[float] | None:
    """The time and the one or two readings of a line; None where it is anything else."""
    cells = line.translate(_SEPARATORS).split()
    if not 2 <= len(cells) <= 3 or b"_" in line:
        return None
    try:
        row = [float(cell) for cell in cells]
    except ValueError:
        return None
    time, *readings = row
    # what is not a number is below nothing
    plausible = abs(time) <= LARGEST and all(abs(x) <= LARGEST_READING for x in readings)
    return row if plausible else None
