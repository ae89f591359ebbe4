"""One run of a rig, from a file or from arrays."""

from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from tp_jax.errors import InputError
from tp_jax.recordings.arrays import arrays_of, recording_fields
from tp_jax.recordings.checks import check_recording
from tp_jax.recordings.recorded_run import RecordedRun


class Recording(RecordedRun):
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
        rotates = bool(given.pop("rotates", False))
        recording = Recording(**recording_fields(t, phi1, phi2, **given))
        check_recording(recording, None, rotates)
        return recording

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
        arrays = arrays_of(frame, columns)
        if given.get("forced") is False or given.get("omega") is not None:
            arrays.pop("drive", None)
        return Recording.from_arrays(**arrays, **given)

    def to_frame(self) -> Any:
        """The columns t, phi1 and, where there are, phi2 and drive as a DataFrame of pandas.

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise InputError("A DataFrame needs pandas: pip install pandas.") from error
        columns = {"t": self.t, **self.channels}
        if self.drive is not None:
            columns["drive"] = self.drive
        return pandas.DataFrame(columns)
