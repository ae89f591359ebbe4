"""Rows of a recording out of the bytes of a rig: readings to angles, each at its time."""

from dataclasses import dataclass

import numpy as np

from tp_jax.acquisition.device import Device
from tp_jax.acquisition.parser import Batch, FrameParser, TextParser
from tp_jax.acquisition.protocol import FULL_SCALE, Ack
from tp_jax.acquisition.timeline import Timeline
from tp_jax.recordings.calibration import Calibration
from tp_jax.recordings.unwrap import Unwrapper


@dataclass(frozen=True)
class Rows:
    """Samples ready to be written."""

    values: np.ndarray  # (n, columns), the time [s] first, then the angles [rad]
    arrival: tuple[float, float] | None = None  # (a sample's time [s], host's clock when it came)


class Stream:
    """The samples of one run, of the kind "frames" or "text"."""

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
            calibration: of its sensors.
            begun: its answer to START or RELEASE; None: a text stream.
            real_time: whether the rig's clock is meant to run as the host's.
        """
        self.device, self.calibration, self.begun = device, calibration, begun
        self.identity = device.identity  # None: text
        self._real_time = real_time
        self.clipped = dict.fromkeys(
            calibration.sensors, 0
        )  # readings at an end of the ADC's range
        self._unwrappers = {
            n: Unwrapper(s.law, winds=n != "phi1") for n, s in calibration.sensors.items()
        }
        self.parser: TextParser | FrameParser
        if begun is None or self.identity is None:
            self.kind, self.parser, self.timeline = "text", TextParser(), Timeline()
            self.names = ("t", "phi1", "phi2")[: device.text.columns or 3]
        else:
            self.kind, self.parser = "frames", FrameParser()
            self.names = ("t", *calibration.sensors)
            self.timeline = Timeline(1.0 / self.identity.rate, begun.time)
            self._volts = self.identity.reference / FULL_SCALE

    @property
    def uncertain(self) -> dict[str, list[float]]:
        """Sensor -> times at which a branch was guessed."""
        return {n: u.uncertain for n, u in self._unwrappers.items()}

    @property
    def time(self) -> str:
        """The time column, in words."""
        if self.kind == "frames":
            return "the rig's clock, 0 at the begin of the run"
        unit = self.timeline.unit
        return "as the rig printed it" + (f", in {unit}" if unit != "seconds" else "")

    @property
    def notes(self) -> list[str]:
        """Sentences on all that was left out or changed."""
        timeline, notes = self.timeline, []
        if timeline.unit != "seconds":
            notes.append(f"The rig's times are {timeline.unit}; they are written in seconds.")
        for at in timeline.wraps:
            notes.append(f"The counter of the rig's times wrapped at {at:.10g} s; they go on.")
        kind, others = ("rows" if self.kind == "text" else "samples"), timeline.implausible
        if timeline.repeated:
            others -= timeline.repeated
            notes.append(
                f"{timeline.repeated} {kind} were left out, since their time is that of the one "
                f"before: it is rounded to {timeline.period or 0.0:g} s; print more digits of it."
            )
        if others:
            notes.append(f"{others} {kind} were left out, since their times do not follow.")
        return notes

    def pending(self) -> list[Rows]:
        """The rows that came while the rig was identified or its answer was waited for."""
        heard, self.device.heard = self.device.heard, []
        return [self.feed(*each) for each in heard]

    def feed(self, data: bytes, arrival: float) -> Rows:
        """The rows that some bytes complete."""
        if isinstance(self.parser, FrameParser):
            return self._of_frames(self.parser.feed(data), arrival)
        rows = self.parser.feed(data)
        believed = self.timeline.feed_rows(rows, arrival if self._real_time else None)
        values = self._angles_of_text(believed)
        # the arrival is not that of a row which was set aside earlier
        own = self.parser.sharp and len(values) > 0
        own = own and values[0, 0] == self.timeline.seconds(rows[0, 0])
        return Rows(values, (float(values[0, 0]), arrival) if own else None)

    def rest(self) -> Rows | None:
        """Rows that were held back, at the end of a short stream of text."""
        rows = self.timeline.rest()
        return None if rows is None else Rows(self._angles_of_text(rows))

    def interrupted(self) -> None:
        """Says that the line was."""
        self.parser.clear()
        self.timeline.interrupted()

    def same_run(self) -> bool:
        """True where the rig, identified again, can have gone on; text tells by its times."""
        now, before = self.device.identity, self.identity
        if self.begun is None or before is None or now is None:
            return self.kind == "text"
        return (now.boot, now.run, now.running) == (before.boot, self.begun.run, True)

    def _of_frames(self, batch: Batch, arrival: float) -> Rows:
        assert self.begun is not None
        own = batch.samples["run"] == self.begun.run  # the others are an older run's
        sharp, samples = batch.sharp and bool(own[0]), batch.samples[own]
        kept, t = self.timeline.feed(samples["sequence"], samples["time"])
        if not t.size:
            return Rows(np.empty((0, len(self.names))))
        counts = samples["readings"][kept]
        volts = {"phi1": counts[:, :2], "phi2": counts[:, 2:]}
        for name, sensor in self.calibration.sensors.items():
            seen = volts[name][:, : 2 if sensor.needs_cosine else 1]
            self.clipped[name] += int(((seen == 0) | (seen == FULL_SCALE)).any(axis=1).sum())
            volts[name] = volts[name] * self._volts
        arrived = (float(t[0]), arrival) if sharp and kept[0] == 0 else None
        return Rows(self._angles(t, volts), arrived)

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
