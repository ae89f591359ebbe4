"""Rows of a recording out of the bytes of a rig: readings to angles, each at its time."""

from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition.calibration import Calibration
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.parser import Batch
from tp_jax.acquisition.protocol import FULL_SCALE, Ack
from tp_jax.acquisition.timeline import Timeline
from tp_jax.acquisition.unwrap import Unwrapper
from tp_jax.errors import InputError


@dataclass(frozen=True)
class Rows:
    """Samples ready to be written.

    Attributes:
        values: (n, columns), the time [s] first, then the angles [rad].
        arrival: (time of a sample [s], host's clock when it came), or None where the two cannot
            be told to belong together.
    """

    values: np.ndarray
    arrival: tuple[float, float] | None = None


class Stream:
    """One run's samples, of frames or of text.

    Attributes:
        kind: "frames" or "text".
        names: of the columns.
        timeline: of the samples.
        parser: of the bytes.
        calibration: of each sensor; of none where a text stream is angles.
        clipped: sensor -> readings at an end of the ADC's range.
    """

    def __init__(
        self,
        device: Device,
        calibration: Calibration,
        begun: Ack | None = None,
        real_time: bool = True,
    ) -> None:
        """
        Args:
            device: identified.
            calibration: of each sensor of a rig that speaks the protocol; of a text stream where
                it is volts.
            begun: the rig's answer to START or RELEASE; None: a text stream.
            real_time: whether the rig's clock is meant to run as the host's.
        """
        self.device, self.calibration, self.begun = device, calibration, begun
        self.clipped = dict.fromkeys(calibration.sensors, 0)
        self._unwrappers = {
            n: Unwrapper(s.law, winds=n != "phi1") for n, s in calibration.sensors.items()
        }
        self._real_time = real_time
        self.identity = device.identity
        if begun is None:
            self.kind, self.parser, self.timeline = "text", device.text, Timeline()
            self.names = ("t", "phi1", "phi2")[: device.text.columns or 3]
            self._check_text()
        else:
            assert device.identity is not None
            self.kind, self.parser = "frames", device.frames
            self.timeline = Timeline(1.0 / device.identity.rate, begun.time)
            self.names = ("t", *calibration.sensors)

    @property
    def uncertain(self) -> dict[str, list[float]]:
        """Sensor -> times at which a branch was guessed."""
        return {n: u.uncertain for n, u in self._unwrappers.items()}

    @property
    def notes(self) -> list[str]:
        """Sentences on what was left out or changed."""
        timeline, notes = self.timeline, []
        if timeline.unit != "seconds":
            notes.append(f"The rig's times are {timeline.unit}; they are written in seconds.")
        for at in timeline.wraps:
            notes.append(
                f"The counter behind the rig's times wrapped at {at:.10g} s; they were carried on."
            )
        others = timeline.implausible - timeline.repeated
        kind = "rows" if self.kind == "text" else "samples"
        if timeline.repeated:
            rounded = f"times rounded to {timeline.period:g} s" if timeline.period else "such times"
            notes.append(
                f"{timeline.repeated} {kind} were left out, since their time is that of the one "
                f"before, as {rounded} are; print more digits of the time."
            )
        if others:
            notes.append(
                f"{others} {kind} were left out, since their times do not follow from those before."
            )
        return notes

    def pending(self) -> list[Rows]:
        """The rows that came while the stream was understood or an answer was waited for."""
        device = self.device
        if self.kind == "frames":
            batches, device.samples = device.samples, []
            return [self._of_frames(*each) for each in batches]
        texts, device.rows = device.rows, []
        return [self._of_text(*each) for each in texts]

    def feed(self, data: bytes, arrival: float) -> Rows:
        """The rows that some bytes complete."""
        if self.kind == "frames":
            return self._of_frames(self.device.frames.feed(data), arrival)
        return self._of_text(self.device.text.feed(data), arrival)

    def rest(self) -> Rows | None:
        """Rows that were held back, at the end of a short stream of text."""
        rows = self.timeline.rest()
        return None if rows is None else Rows(self._angles_of_text(rows))

    def same_run(self) -> bool:
        """Whether the rig, identified again, can have gone on; text tells by its times."""
        now, before = self.device.identity, self.identity
        if self.begun is None or before is None or now is None:
            return self.begun is None
        return (now.boot, now.run, now.running) == (before.boot, self.begun.run, True)

    def _of_frames(self, batch: Batch, arrival: float) -> Rows:
        assert self.begun is not None
        assert self.identity is not None
        samples, own = batch.samples, batch.samples["run"] == self.begun.run
        sharp = batch.sharp and bool(own[0])
        samples = samples[own]  # the others are an older run's
        kept, t = self.timeline.feed(samples["sequence"], samples["time"])
        if not t.size:
            return Rows(np.empty((0, len(self.names))))
        counts = samples["readings"][kept]
        volts = {"phi1": counts[:, :2], "phi2": counts[:, 2:]}
        for name, sensor in self.calibration.sensors.items():
            seen = volts[name][:, : 2 if sensor.needs_cosine else 1]
            self.clipped[name] += int(((seen == 0) | (seen == FULL_SCALE)).any(axis=1).sum())
            volts[name] = volts[name] * (self.identity.reference / FULL_SCALE)
        arrived = (float(t[0]), arrival) if sharp and kept[0] == 0 else None
        return Rows(self._angles(t, volts), arrived)

    def _of_text(self, rows: np.ndarray, arrival: float) -> Rows:
        sharp = self.device.text.sharp
        values = self._angles_of_text(
            self.timeline.feed_rows(rows, arrival if self._real_time else None)
        )
        sharp = sharp and len(values) > 0 and values[0, 0] == self.timeline.seconds(rows[0, 0])
        return Rows(values, (float(values[0, 0]), arrival) if sharp else None)

    def _angles_of_text(self, rows: np.ndarray) -> np.ndarray:
        if not self.calibration.sensors or not len(rows):
            return rows
        volts = {n: rows[:, [i, i]] for i, n in enumerate(self.names) if i}
        return self._angles(rows[:, 0], volts)

    def _angles(self, t: np.ndarray, volts: dict[str, np.ndarray]) -> np.ndarray:
        """(n, columns) of times and the angles of each sensor, of its (n, 2) volts."""
        angles = [
            self._unwrappers[name].feed(t, sensor.angle(volts[name]))
            for name, sensor in self.calibration.sensors.items()
        ]
        return np.column_stack([t, *angles])

    def _check_text(self) -> None:
        sensors = self.calibration.sensors
        missing = [n for n in self.names[1:] if sensors and n not in sensors]
        if missing:
            raise InputError(
                f"The calibration {self.calibration.source} has no [{missing[0]}], which the "
                "stream has; add it."
            )
        for name, sensor in sensors.items():
            if sensor.needs_cosine:
                raise InputError(
                    f"The calibration of {name} needs the cosine bridge, but a text stream has one "
                    'column for a sensor; use the law "sine" or "line".'
                )
