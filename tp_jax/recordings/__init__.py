"""Recordings of a rig, and the campaigns they make: reading, checking, writing.

    kinds                       what a file is by its first bytes
    lines, cells -> layout      a text to its cells; clock_times
    joined                      names of columns again, where logs were joined
    readers -> tables           other files, each kind by a library
    units, sources -> columns -> formats   data files to columns in seconds and radians
    clocks, rounding, held -> readings  cells to times that run on and readings that are new
    sections -> format_section, entries    campaign.toml to what it says
    recorded_run -> checks, arrays -> recording    one run, and whether it can be what is said
    odd_units                   files whose angles are in another unit, by their noise
    encoder                     readings that start anew after a turn
    campaign                    all of them together: `load_campaign`
    gaps                        where samples were lost
    thinning                    means of blocks, where there are samples to spare
    colour, noise_colour        correlated noise; what the angles alone say of it
    noise, smooth, holdout      noise levels, starting states, what is never fitted
    calibration_error           how far a calibration may have put the angles off
    calibration, calibration_run    bridge volts to angles, with errors; one from known angles
    unwrap                      an angle beyond what a bridge can tell by one reading
    writer                      CSV out

Every fault of the user's files is a `CampaignError`, one sentence that names file, line and mend.
NumPy and the standard library only: recording does not wait for JAX.
"""

from tp_jax.recordings.calibration_error import CalibrationError as CalibrationError
from tp_jax.recordings.campaign import Campaign as Campaign
from tp_jax.recordings.campaign import load_campaign as load_campaign
from tp_jax.recordings.checks import LEAST_SAMPLES as LEAST_SAMPLES
from tp_jax.recordings.colour import Colour as Colour
from tp_jax.recordings.columns import Columns as Columns
from tp_jax.recordings.entries import Known as Known
from tp_jax.recordings.faults import CampaignError as CampaignError
from tp_jax.recordings.formats import ColumnSource as ColumnSource
from tp_jax.recordings.formats import FileFormat as FileFormat
from tp_jax.recordings.formats import read_columns as read_columns
from tp_jax.recordings.gaps import stretches as stretches
from tp_jax.recordings.holdout import hold_out as hold_out
from tp_jax.recordings.noise import noise_level as noise_level
from tp_jax.recordings.noise import noise_levels as noise_levels
from tp_jax.recordings.noise_colour import noise_colour as noise_colour
from tp_jax.recordings.noise_colour import same_rate as same_rate
from tp_jax.recordings.recording import Recording as Recording
from tp_jax.recordings.smooth import Smoothed as Smoothed
from tp_jax.recordings.smooth import local_polynomial as local_polynomial
from tp_jax.recordings.thinning import block_length as block_length
from tp_jax.recordings.thinning import thinned as thinned
from tp_jax.recordings.writer import write_csv as write_csv
