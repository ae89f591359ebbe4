"""Rows of a recording from a stream of text."""

from collections.abc import Iterable

import numpy as np

from tp_jax.acquisition.calibration import Calibration
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.rows import Angles, AnyTimeline, Rows
from tp_jax.acquisition.text_timeline import TextTimeline
from tp_jax.errors import InputError


class TextSource:
    """A stream of `t phi1 phi2`; attributes as in `frame_source.FrameSource`."""

    stream = "text"

    def __init__(self, device: Device, calibration: Calibration | None) -> None:
        """
        Args:
            device: found to send text.
            calibration: where the stream is volts; None: it is angles.
        """
        self.device = device
        columns = device.text.columns or 3
        self.names = ("t", "phi1", "phi2")[:columns]
        self.timeline: AnyTimeline
        self.timeline = self._timeline = TextTimeline()
        self.angles = Angles(calibration or Calibration())
        missing = [n for n in self.names[1:] if calibration and n not in calibration.sensors]
        if missing:
            raise InputError(
                f"The calibration {self.angles.calibration.source} has no [{missing[0]}], which "
                "the stream has; add it."
            )
        for name, sensor in self.angles.calibration.sensors.items():
            if sensor.needs_cosine:
                raise InputError(
                    f"The calibration of {name} needs the cosine bridge, but a text stream has one "
                    'column for a sensor; use the law "sine" or "line".'
                )

    def pending(self) -> Iterable[Rows]:
        """What came until the stream was understood."""
        waiting, self.device.rows = self.device.rows, []
        return [self._rows(rows) for rows, _ in waiting]

    def feed(self, data: bytes, arrival: float) -> Rows:
        """The rows that some bytes complete."""
        text = self.device.text
        rows = text.feed(data)
        made = self._rows(rows)
        values = made.values
        if text.sharp and len(values) and len(values) <= len(rows) and values[0, 0] == rows[0, 0]:
            return Rows(values, (float(values[0, 0]), arrival))
        return made

    def last_rows(self) -> Rows | None:
        """Rows that were held back, at the end of a short stream."""
        rows = self._timeline.rest()
        return None if rows is None else Rows(self._angles(rows))

    def frames(self) -> dict[str, int]:
        """Counts for the metadata; lines here."""
        return {"good": self.device.text.good, "corrupt": self.device.text.corrupt, "unknown": 0}

    def same_run(self) -> bool:
        """Whether it can have gone on: its times will tell."""
        return True

    def _rows(self, rows: np.ndarray) -> Rows:
        return Rows(self._angles(self._timeline.feed(rows)))

    def _angles(self, rows: np.ndarray) -> np.ndarray:
        if not self.angles.calibration.sensors or not len(rows):
            return rows
        t = rows[:, 0]
        volts = {n: rows[:, [i, i]] for i, n in enumerate(self.names) if i}
        return np.column_stack([t, *self.angles.of(t, volts)])
