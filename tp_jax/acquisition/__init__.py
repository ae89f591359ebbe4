"""Recording from a rig at a serial port: the protocol, the recorder, the calibration.

    frames -> protocol -> parser        the bytes of frames or lines of text, damaged or not
    port -> device                      who is there, and what it is told
    timeline -> streams                 when samples were taken, which are missing; their angles
    writer, clock -> run_log            the file, and all that is known of it
    recorder                            the run itself
    campaign_entry                      its place in a campaign.toml

`recordings.calibration` makes angles of volts. NumPy, pySerial and cobs only, so that recording
starts at once. firmware/ holds sketches of what a rig has to send.
"""

from tp_jax.acquisition.clock import ClockFit as ClockFit
from tp_jax.acquisition.clock import fit_clock as fit_clock
from tp_jax.acquisition.port import Port as Port
from tp_jax.acquisition.recorder import record as record
from tp_jax.acquisition.run_log import Recorded as Recorded
from tp_jax.acquisition.run_log import Settings as Settings
from tp_jax.acquisition.run_log import Status as Status
from tp_jax.recordings.calibration import Calibration as Calibration
from tp_jax.recordings.calibration import SensorCalibration as SensorCalibration
from tp_jax.recordings.calibration import read_calibration as read_calibration
from tp_jax.recordings.calibration import write_calibration as write_calibration
from tp_jax.recordings.calibration_run import calibrate as calibrate
from tp_jax.recordings.calibration_run import fit_calibration as fit_calibration
