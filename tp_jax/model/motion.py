"""Quantities that an effect may look at: the motion and the torques of one instant."""

from typing import Any


class Motion:
    """Quantities of one instant, filled in the order in which the equations need them.

    Every entry has the shape of the state's components (a scalar, or one number per lane).

    Attributes:
        t: time [s]; s: time within the recording, from -1/2 to 1/2.
        phi1, phi2, v1, v2: angles [rad] and velocities [rad/s]; phi2 and v2 are relative to the
            column.
        theta, A, f, d: drive phase [rad], amplitude [rad], angle f_e [rad], winding of the spring
            [rad], f - phi1 and its preload.
        f_rate: function of nothing that gives the rate of f [rad/s], worked out when asked for.
        later: function of a time [s] that gives what f gains [rad] if a measured drive is read so
            much later; zero for a sine.
        k, spring: stiffness [N m/rad], spring torque on the column [N m].
        sign1, M1, bearing_dry, bearing_viscous, bearing: smoothed sign of v1, coefficient [N m],
            the two parts and their sum M_L [N m].
        sign2, Ts1, contact_dry, contact_viscous, contact: likewise for the contact, M_T [N m].
        B1, B2: inertias [kg m^2].
        a1, a2: accelerations [rad/s^2], the derivatives of v1 and v2; set only where the sensors
            are evaluated.
        z: tuple of the effects' own states.
        hook: quantity that is added to, while an effect is asked.
        wound: as d, of the drive without its effects [rad]; curve: value of a law, once asked.
    """

    __slots__ = (
        "A",
        "B1",
        "B2",
        "M1",
        "Ts1",
        "a1",
        "a2",
        "bearing",
        "bearing_dry",
        "bearing_viscous",
        "contact",
        "contact_dry",
        "contact_viscous",
        "curve",
        "d",
        "f",
        "f_rate",
        "hook",
        "k",
        "later",
        "phi1",
        "phi2",
        "s",
        "sign1",
        "sign2",
        "spring",
        "t",
        "theta",
        "v1",
        "v2",
        "wound",
        "z",
    )

    def __init__(self, **values: Any):
        for name, value in values.items():
            setattr(self, name, value)
