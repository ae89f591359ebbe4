"""State of a recording, on a terminal: its counts, and a small plot of the last seconds."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

    from tp_jax.acquisition.run_log import Progress, Status

WIDTH, HEIGHT = 64, 6

_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))  # of a Braille cell, column by column


@contextmanager
def live(*, quiet: bool) -> "Iterator[Progress | None]":
    """A `progress` for the recorder, where standard error is a terminal; else None."""
    if quiet or not sys.stderr.isatty():
        yield None
        return

    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    console = Console(stderr=True)
    shown = Live(console=console, transient=True, refresh_per_second=8)

    def report(status: "Status") -> None:
        with suppress(OSError):
            shown.update(Text(screen(status, min(WIDTH, console.width - 8))))

    # A terminal that is closed ends the recording, which is then written about all the same.
    with suppress(OSError):
        shown.start()
    try:
        yield report
    finally:
        with suppress(OSError):
            shown.stop()


def screen(status: "Status", width: int = WIDTH) -> str:
    """The text shown: a line of counts, and a plot of each angle."""
    rate = "" if status.rate is None else f"  {status.rate:.0f} Hz"
    head = (
        f"{status.t:.1f} of {status.duration:g} s{rate}  {status.written} samples  "
        f"{status.lost} lost  {status.corrupt} corrupt"
    )
    if status.unplugged:
        head += "  unplugged, waiting for it"
    parts = [head]
    for i, name in enumerate(status.names):
        if i and len(status.recent) > 1:
            parts.append(f"{name} [rad]")
            parts.append(plot(status.recent[:, 0], status.recent[:, i], width))
    return "\n".join(parts)


def plot(t: "np.ndarray", y: "np.ndarray", width: int = WIDTH, height: int = HEIGHT) -> str:
    """(n,) values y over (n,) times as lines of Braille, with the least and the largest value."""
    import numpy as np

    low, high = float(y.min()), float(y.max())
    column = np.rint((t - t[0]) / max(t[-1] - t[0], 1e-12) * (2 * width - 1)).astype(int)
    row = np.rint((high - y) / max(high - low, 1e-12) * (4 * height - 1)).astype(int)
    cells = np.zeros((height, width), dtype=int)
    np.bitwise_or.at(cells, (row // 4, column // 2), np.array(_DOTS)[column % 2, row % 4])
    lines = ["".join(chr(0x2800 + dots) for dots in line) for line in cells]
    lines[0] += f" {high:+.3f}"
    lines[-1] += f" {low:+.3f}"
    return "\n".join(lines)
