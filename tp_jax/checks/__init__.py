"""Checks that recordings can be what they are said to be: units, angles, frequencies, sampling.

    policy                    every threshold, with its unit and reason
    harmonics -> drive        does a run move at its omega; which unit was taken for another
                 rider        is phi2 the rider's angle against the column, and in its sense
                 angle_units  is an angle in another unit, in one file or in all
    sampling                  samples, noise, clipping, decays that do not decay
    held_readings             a sensor slower than the file
    starts                    runs that begin at times of their own
    survey -> proposal        a campaign.toml for files of unknown make
    -> checking               all of a campaign at once, `check`; what is certain is refused

NumPy only: an answer takes less than a second, before anything is fitted.
"""

from tp_jax.checks.checking import Checked as Checked
from tp_jax.checks.checking import check as check
from tp_jax.checks.checking import examine as examine
from tp_jax.checks.finding import Finding as Finding
from tp_jax.checks.policy import CheckPolicy as CheckPolicy
