"""Effects beyond the package's catalogue, which the virtual rig can hide once this is imported.

base                                           `Outside`, and `Cousin` for another formula of a kind
patterns                                       shapes over angle and time that several cousins share
outside_column, _contact, _sensors, _clock     effects that the catalogue lacks
cousins_drive, _spring, _bearing, _contact, _column, _sensors      its kinds by other formulas
"""

from tp_jax.rig.effects import register
from trials.effects import (
    cousins_bearing,
    cousins_column,
    cousins_contact,
    cousins_drive,
    cousins_sensors,
    cousins_spring,
    outside_clock,
    outside_column,
    outside_contact,
    outside_sensors,
)

FAMILIES = (
    outside_column,
    outside_contact,
    outside_sensors,
    outside_clock,
    cousins_drive,
    cousins_spring,
    cousins_bearing,
    cousins_contact,
    cousins_column,
    cousins_sensors,
)

for _family in FAMILIES:
    register(_family)
