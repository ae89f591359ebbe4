"""Contents of a recording of one run of a rig: times, angles, and how it was driven."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from tp_jax.recordings.calibration_error import CalibrationError
from tp_jax.recordings.sources import ColumnSource

Run = TypeVar("Run", bound="RecordedRun")


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """Contents of a `Recording`, which says what each field is; not checked."""

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

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.t.size

    @property
    def duration(self) -> float:
        """Duration from the first to the last sample [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def measured_drive(self) -> bool:
        """True if the drive was measured rather than commanded."""
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

    def cut(self: Run, t0: float, t1: float) -> Run:
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
