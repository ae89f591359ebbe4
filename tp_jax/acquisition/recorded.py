"""A recording that was made."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Recorded:
    """A recording that was written.

    Attributes:
        path: the file.
        state: how it ended: complete, interrupted, unplugged, restarted or silent.
        omega: of the drive [rad/s], on the time column; None where it was not driven.
        forced: whether the motor ran.
        duration: from the first to the last sample [s].
        metadata: as in the file beside it.
    """

    path: Path
    state: str
    omega: float | None
    forced: bool
    duration: float
    metadata: dict[str, Any]

    @property
    def rows(self) -> int:
        """Samples in the file."""
        return self.metadata["samples"]["written"]

    @property
    def fault(self) -> str | None:
        """Why it ended before its time, in one sentence; None where it did not, or was asked to."""
        why = {
            "unplugged": "the rig was unplugged and did not come back",
            "restarted": "the rig has restarted, and its run with it",
            "silent": "the rig fell silent",
        }.get(self.state)
        if why is None:
            return None
        return (
            f"The recording ended after {self.duration:.6g} s, since {why}; {self.path} keeps the "
            f"{self.rows} samples until then."
        )
