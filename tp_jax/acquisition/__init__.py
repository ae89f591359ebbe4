"""From a rig at a serial port to a recording: the protocol, the recorder, the calibration.

    frames -> protocol -> parser        the rig's messages, damaged or not   (firmware/ sends them)
    text_stream                         or plain lines of `t phi1 phi2`
    timeline, text_timeline             when samples were taken, which are missing
    calibration, unwrap                 volts to angles, with their errors
    calibration_run, calibration_fit, calibration_file   one from known angles; TOML
    port -> device -> frame_source, text_source -> recorder     the recording itself: `record`,
                                        of `settings` a `recorded`
    clock                               the rig's clock against the host's
    writer, log, metadata, files        what is written, and that nothing of it is lost
    campaign_entry                      a recording's place in a campaign.toml

NumPy, pySerial and cobs only, so that recording starts at once; SciPy where a calibration is
fitted. The names below are looked up when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tp_jax.acquisition.calibration import Calibration as Calibration
    from tp_jax.acquisition.calibration import SensorCalibration as SensorCalibration
    from tp_jax.acquisition.calibration_file import read_calibration as read_calibration
    from tp_jax.acquisition.calibration_file import write_calibration as write_calibration
    from tp_jax.acquisition.calibration_fit import fit_calibration as fit_calibration
    from tp_jax.acquisition.calibration_run import calibrate as calibrate
    from tp_jax.acquisition.clock import ClockFit as ClockFit
    from tp_jax.acquisition.clock import fit_clock as fit_clock
    from tp_jax.acquisition.port import Port as Port
    from tp_jax.acquisition.recorded import Recorded as Recorded
    from tp_jax.acquisition.recorder import record as record
    from tp_jax.acquisition.settings import Settings as Settings
    from tp_jax.acquisition.status import Status as Status

_MODULES = {
    "Calibration": "calibration",
    "ClockFit": "clock",
    "Port": "port",
    "Recorded": "recorded",
    "SensorCalibration": "calibration",
    "Settings": "settings",
    "Status": "status",
    "calibrate": "calibration_run",
    "fit_calibration": "calibration_fit",
    "fit_clock": "clock",
    "read_calibration": "calibration_file",
    "record": "recorder",
    "write_calibration": "calibration_file",
}

__all__ = [
    "Calibration",
    "ClockFit",
    "Port",
    "Recorded",
    "SensorCalibration",
    "Settings",
    "Status",
    "calibrate",
    "fit_calibration",
    "fit_clock",
    "read_calibration",
    "record",
    "write_calibration",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"tp_jax.acquisition.{_MODULES[name]}"), name)
    globals()[name] = value  # looked up once
    return value
