"""Rows of a recording from a rig that speaks the protocol."""

from collections.abc import Iterable

import numpy as np

from tp_jax.acquisition.calibration import Calibration
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.parser import Batch
from tp_jax.acquisition.protocol import FULL_SCALE, Ack
from tp_jax.acquisition.rows import Angles, AnyTimeline, Rows
from tp_jax.acquisition.timeline import Timeline


class FrameSource:
    """A rig that speaks the protocol.

    Attributes:
        names: of the columns.
        timeline: of its samples.
        angles: readings to angles.
    """

    stream = "frames"

    def __init__(self, device: Device, calibration: Calibration, begun: Ack) -> None:
        """
        Args:
            device: identified.
            calibration: of each sensor it has.
            begun: its answer to START or RELEASE.
        """
        identity = device.identity
        assert identity is not None
        self.device = device
        self.identity = identity
        self.begun = begun
        self.timeline: AnyTimeline
        self.timeline = self._timeline = Timeline(1.0 / identity.rate, begun.time)
        self.angles = Angles(calibration)
        self.names = ("t", *calibration.sensors)
        self._volts = identity.reference / FULL_SCALE

    def pending(self) -> Iterable[Rows]:
        """What came while an answer was waited for."""
        waiting, self.device.samples = self.device.samples, []
        return [self._rows(batch, arrival) for batch, arrival in waiting]

    def feed(self, data: bytes, arrival: float) -> Rows:
        """The rows that some bytes complete."""
        return self._rows(self.device.frames.feed(data), arrival)

    def frames(self) -> dict[str, int]:
        """Counts for the metadata."""
        parser = self.device.frames
        return {"good": parser.good, "corrupt": parser.corrupt, "unknown": parser.unknown}

    def same_run(self) -> bool:
        """Whether the rig, identified again, can have gone on."""
        now = self.device.identity
        return now is not None and (now.boot, now.run, now.running) == (
            self.identity.boot,
            self.begun.run,
            True,
        )

    def _rows(self, batch: Batch, arrival: float) -> Rows:
        samples, sharp = batch.samples, batch.sharp
        if samples.size and not (samples["run"] == self.begun.run).all():
            sharp = sharp and bool(samples["run"][0] == self.begun.run)
            samples = samples[samples["run"] == self.begun.run]  # the others are an older run's
        kept, t = self._timeline.feed(samples["sequence"], samples["time"])
        if not t.size:
            return Rows(np.empty((0, len(self.names))))
        counts = samples["readings"]
        counts = counts if t.size == samples.size else counts[kept]
        volts, readings = {}, counts * self._volts
        ends = (counts == 0) | (counts == FULL_SCALE)
        for sensor, calibration in self.angles.calibration.sensors.items():
            first = 0 if sensor == "phi1" else 2
            volts[sensor] = readings[:, first : first + 2]
            own = ends[:, first : first + (2 if calibration.needs_cosine else 1)]
            if own.any():
                self.angles.clipped[sensor] += int(own.any(axis=1).sum())
        values = np.column_stack([t, *self.angles.of(t, volts)])
        return Rows(values, (float(t[0]), arrival) if sharp and kept[0] == 0 else None)
