"""One run of a rig: times, angles, and how it was driven."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tp_jax.recordings.calibration_error import CalibrationError
from tp_jax.recordings.sources import ColumnSource


@dataclass(frozen=True, eq=False)
class Recording:
    """One run, or the span of it that is to be used.

    Arrays are read-only. Two recordings are equal only where they are the same object.

    Attributes:
        name: the file as the campaign names it.
        label: unique in its campaign: the name, with the span where a file appears more than once
            or was cut ("run.csv[0,200]").
        file: the data file.
        t: (n,) times [s] as in the file, rising, not shifted and not necessarily uniform; where
            samples were lost they jump (see `gaps`).
        phi1: (n,) angle of the column [rad].
        phi2: (n,) angle of the ring [rad]; None on a single pendulum.
        drive: (n,) measured drive, in an unknown unit; only where the drive is measured.
        forced: whether the motor ran; otherwise it stood at neutral.
        omega: commanded frequency of the drive [rad/s]; None for a decay, and where the drive is
            measured and nobody said.
        span: (t0, t1) [s], the part of the file that is used; None: all of it.
        start: the campaign's clock [s] at t = 0 of the file; None where it is not known.
        repeat: the group of recordings of the same setting that this one is of.
        held_out: never fitted, only predicted and scored.
        sha256: of the file's bytes.
        drift_over: (t0, t1) [s] that slow drifts run over; None: the recording. The parts of one
            that was cut keep the clock of the whole.
        calibration_error: channel -> how far its calibration may have put it off; channels of
            which that is not known are absent.
        sources: channel -> where in the file it came from, with its unit; empty without a file.
        notes: what was done to the rows when they were read, a sentence each, without its end.
        started: when it was made, in ISO 8601; None where its metadata do not say.
    """

    name: str
    label: str
    file: Path
    t: np.ndarray
    phi1: np.ndarray
    phi2: np.ndarray | None
    drive: np.ndarray | None
    forced: bool
    omega: float | None
    span: tuple[float, float] | None
    start: float | None
    repeat: str | None
    held_out: bool
    sha256: str
    calibration_error: Mapping[str, CalibrationError] = field(default_factory=dict)
    drift_over: tuple[float, float] | None = None
    sources: Mapping[str, ColumnSource] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    started: str | None = None

    def __repr__(self) -> str:
        drive = (
            "free decay"
            if not self.forced
            else "measured drive"
            if self.omega is None
            else (f"omega={self.omega:.6g}")
        )
        more = ", held out" if self.held_out else ""
        return (
            f"Recording({self.label!r}, {' and '.join(self.channels)}, {self.n} samples in "
            f"{self.duration:.4g} s, {drive}{more})"
        )

    def __post_init__(self) -> None:
        for name in ("t", "phi1", "phi2", "drive"):
            array = getattr(self, name)
            if array is not None:
                array = np.asarray(array, dtype=float).view()  # the caller's own stays writable
                array.setflags(write=False)
                object.__setattr__(self, name, array)

    @staticmethod
    def from_arrays(
        t: ArrayLike, phi1: ArrayLike, phi2: ArrayLike | None = None, **given: Any
    ) -> "Recording":
        """A recording of arrays, checked as one from a file.

        Args:
            t: (n,) times: numbers, or NumPy's dates.
            phi1, phi2: (n,) angles of the column and, where there is one, of the rider.
            **given: omega [rad/s] of the drive, or `drive`, (n,) readings of it; neither for a
                decay. `name`; `t_unit` ("s", "ms", ...) and `angle_unit` ("rad", "deg", ...);
                `rotates`, whether the column may wind on; and span, start, repeat, held_out as
                above.

        Raises:
            InputError: the arrays cannot be what they are said to be.

        Example:
            >>> t = np.linspace(0.0, 10.0, 2501)
            >>> Recording.from_arrays(t, 20 * np.sin(13 * t), omega=13.0, angle_unit="deg").n
            2501
        """
        from tp_jax.recordings.arrays import recording_from_arrays

        return recording_from_arrays(t, phi1, phi2, **given)

    @staticmethod
    def from_frame(
        frame: Any, columns: Mapping[str, str] | None = None, **given: Any
    ) -> "Recording":
        """A recording of a DataFrame (of pandas, or one with the same methods).

        Args:
            frame: with columns t, phi1 and, where there are, phi2 and drive.
            columns: name here -> name in the frame, where they differ.
            **given: as of `from_arrays`.

        Raises:
            InputError: a column is missing, or cannot be what it is said to be.
        """
        from tp_jax.recordings.arrays import from_frame

        return from_frame(frame, columns, given)

    def to_frame(self) -> Any:
        """The columns t, phi1 and, where there are, phi2 and drive as a DataFrame of pandas."""
        from tp_jax.recordings.arrays import frame_of

        return frame_of(self)

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.t.size

    @property
    def duration(self) -> float:
        """From the first to the last sample [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def measured_drive(self) -> bool:
        """Whether the drive was measured rather than commanded."""
        return self.drive is not None

    @property
    def channels(self) -> dict[str, np.ndarray]:
        """The measured angles, name -> (n,) values [rad]."""
        both = {"phi1": self.phi1, "phi2": self.phi2}
        return {name: values for name, values in both.items() if values is not None}

    @property
    def drift(self) -> tuple[float, float]:
        """Middle [s] and rate [1/s] of the clock of slow drifts, -1/2 to 1/2 over the recording."""
        begin, end = self.drift_over or (float(self.t[0]), float(self.t[-1]))
        return 0.5 * (begin + end), 1.0 / (end - begin)

    @property
    def clock(self) -> np.ndarray | None:
        """(n,) times on the campaign's clock [s]; None where `start` is not known."""
        return None if self.start is None else self.start + self.t

    def cut(self, t0: float, t1: float) -> "Recording":
        """The samples with t0 <= t <= t1 as a recording of their own.

        Raises:
            ValueError: no sample lies in there.
        """
        part = slice(*within(self.t, t0, t1))
        if part.start >= part.stop:
            raise ValueError(
                f"Recording {self.label} has no sample in [{t0:g}, {t1:g}] s, but lasts from "
                f"{self.t[0]:g} to {self.t[-1]:g} s."
            )
        span = (float(t0), float(t1))
        return replace(
            self,
            label=spanned(self.name, span),
            t=self.t[part],
            phi1=self.phi1[part],
            phi2=None if self.phi2 is None else self.phi2[part],
            drive=None if self.drive is None else self.drive[part],
            span=span,
        )


def within(t: np.ndarray, t0: float, t1: float) -> tuple[int, int]:
    """Indices from which and up to which (not included) the rising times t lie in [t0, t1]."""
    return int(np.searchsorted(t, t0, "left")), int(np.searchsorted(t, t1, "right"))


def spanned(name: str, span: tuple[float, float]) -> str:
    """Label of a span of a file, "Cassy.txt[200,661]"."""
    return f"{name}[{span[0]:g},{span[1]:g}]"
