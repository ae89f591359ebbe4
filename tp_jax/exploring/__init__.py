"""The loop closed between rig and diagnosis: record, diagnose, choose the next run, go on.

state       what is known between two runs, in a file beside the recordings
loop        the rounds, with whatever records and whatever diagnoses

The choice of the next run is `tp_jax.gap.next_run`, its forecasts are `tp_jax.gap.forecast`.
"""

from tp_jax.exploring.loop import Explored as Explored
from tp_jax.exploring.loop import explore as explore
