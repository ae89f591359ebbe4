"""What is to be recorded, and how."""

from collections.abc import Sequence
from dataclasses import dataclass

from tp_jax.acquisition.calibration import Calibration


@dataclass(frozen=True)
class Settings:
    """What is to be recorded, and how.

    Attributes:
        duration: from the begin of the run [s], both ends included.
        omega: of the drive [rad/s]; None: the motor stands at neutral.
        amplitude: of the drive [rad]; None: what the rig has.
        release: angle [rad] the column is let go from; excludes omega.
        calibration: None: what the rig announces, or nominal values.
        patience: seconds in which a rig must answer, and may be silent.
        reconnect: seconds in which an unplugged one must be back.
        real_time: whether the rig's clock is meant to run as the host's.
        command: that asked for it, for the metadata.
    """

    duration: float
    omega: float | None = None
    amplitude: float | None = None
    release: float | None = None
    calibration: Calibration | None = None
    patience: float = 5.0
    reconnect: float = 30.0
    real_time: bool = True
    command: Sequence[str] = ()
