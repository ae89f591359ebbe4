"""Samples on their way into a recording: rows, and the sensors' angles in them."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tp_jax.acquisition.calibration import Calibration
from tp_jax.acquisition.timeline import Gap
from tp_jax.acquisition.unwrap import Unwrapper


class AnyTimeline(Protocol):
    """What the two timelines have in common."""

    accepted: int
    lost: int
    implausible: int
    restarted: bool

    @property
    def period(self) -> float | None: ...
    @property
    def last(self) -> float | None: ...
    def take_gaps(self) -> list[Gap]: ...
    def interrupted(self) -> None: ...


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


class Angles:
    """Readings to angles, sensor by sensor, followed through the recording.

    Attributes:
        clipped: sensor -> readings at an end of the ADC's range.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self.clipped = dict.fromkeys(calibration.sensors, 0)
        self._unwrappers = {
            n: Unwrapper(s.law, winds=n != "phi1") for n, s in calibration.sensors.items()
        }

    @property
    def uncertain(self) -> dict[str, list[float]]:
        """Sensor -> times at which a branch was guessed."""
        return {n: u.uncertain for n, u in self._unwrappers.items()}

    def of(self, t: np.ndarray, volts: dict[str, np.ndarray]) -> list[np.ndarray]:
        """(n,) angles of each sensor at (n,) times, of its (n, 2) volts."""
        return [
            self._unwrappers[name].feed(t, sensor.angle(volts[name]))
            for name, sensor in self.calibration.sensors.items()
        ]
