"""Units in proportion to the column's inertia B1, which no angle shows.

Where B1 is not given, B1 = 1 is taken, and inertias and torques are known per unit of it.
"""

BEGINNINGS = ("N m", "kg m^2")
"""Beginnings of these units: torques, what multiplies an angle or a speed to one, inertias."""


def scales(unit: str) -> bool:
    """True if a number of this unit is in proportion to B1."""
    return unit.startswith(BEGINNINGS)


def per_inertia(unit: str) -> str:
    """A torque's or an inertia's unit per unit of B1; any other as it is."""
    return f"{unit}/B1" if scales(unit) else unit
