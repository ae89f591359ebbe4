"""Names, units, bounds and transforms of the parameters.

Bounds are relative to the scale of the rig: torques and inertias are bounded in units of B1 (and
a natural rate), since only their ratios act on the motion.
"""

import dataclasses
from typing import Any, Literal

import numpy as np

Transform = Literal["log", "identity", "asinh"]


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One parameter of the model.

    Attributes:
        name: as in the paper where it has it.
        unit: SI unit.
        lower, upper: bounds in SI units for B1 = `REFERENCE_B1`; `scaled` moves them.
        transform: coordinate in which it is estimated. "log" keeps it positive; "identity" lets
            it reach a bound at zero (friction that is not there); "asinh" of value / typical is
            linear below the typical size and logarithmic above it: it spans decades like a
            logarithm, and yet zero is a few steps away (the spring of a column that gravity holds).
        per_inertia: whether it scales with B1 (inertias and torques do).
        scope: one value per "campaign", or one per "recording".
        typical: size of a typical step, for scaling.
        free: whether it is estimated unless somebody fixes it.
        description: one line.
    """

    name: str
    unit: str
    lower: float
    upper: float
    transform: Transform = "identity"
    per_inertia: bool = False
    scope: Literal["campaign", "recording"] = "campaign"
    typical: float = 1.0
    free: bool = True
    description: str = ""

    def scaled(self, B1: float) -> "Parameter":
        """The same with bounds and typical size for another inertia of the column [kg m^2]."""
        if not self.per_inertia:
            return self
        f = B1 / REFERENCE_B1
        return dataclasses.replace(
            self, lower=self.lower * f, upper=self.upper * f, typical=self.typical * f
        )

    def to_coordinate(self, value: np.ndarray | float) -> np.ndarray | float:
        """Value to the coordinate in which it is estimated."""
        value = np.asarray(value, dtype=float)
        if self.transform == "log":
            return np.log(value)
        scaled = value / self.typical
        return np.arcsinh(scaled) if self.transform == "asinh" else scaled

    def from_coordinate(self, u: np.ndarray | float) -> np.ndarray | float:
        """Coordinate to value."""
        u = np.asarray(u, dtype=float)
        if self.transform == "log":
            return np.exp(u)
        return (np.sinh(u) if self.transform == "asinh" else u) * self.typical

    def slope(self, value: float) -> float:
        """Derivative of the value with respect to its coordinate."""
        if self.transform == "log":
            return value
        return float(np.hypot(value, self.typical)) if self.transform == "asinh" else self.typical


REFERENCE_B1 = 1.0e-3  # kg m^2, the size of rig for which the bounds below are written

_TORQUE: dict[str, Any] = dict(unit="N m", per_inertia=True)
_VISCOUS: dict[str, Any] = dict(unit="N m s/rad", per_inertia=True)

#: The physical parameters of equations (3b), (5), (6) and (16), in the order of Listing 1 where
#: they stand there.
BASE = (
    Parameter(
        "B1", "kg m^2", 1e-5, 1e-1, "log", True, free=False, description="inertia of the column"
    ),
    Parameter("B2", "kg m^2", 1e-5, 1e-1, "log", True, description="inertia of the rider"),
    Parameter(
        "k",
        "N m/rad",
        1e-5,
        1e2,
        "asinh",
        True,
        typical=0.1,
        description="stiffness of the torsion spring",
    ),
    Parameter("A", "rad", 1e-3, 3.0, "log", description="amplitude of the drive"),
    Parameter(
        "c1", lower=0.0, upper=1.0, typical=1e-3, **_VISCOUS, description="viscous bearing friction"
    ),
    Parameter(
        "M1", lower=0.0, upper=1.0, typical=5e-3, **_TORQUE, description="dry bearing friction"
    ),
    Parameter(
        "Tv", lower=0.0, upper=1.0, typical=1e-3, **_VISCOUS, description="viscous contact friction"
    ),
    Parameter(
        "Ts1", lower=0.0, upper=1.0, typical=1e-2, **_TORQUE, description="dry contact friction"
    ),
    Parameter(
        "Ts2",
        lower=0.0,
        upper=1.0,
        typical=1e-2,
        free=False,
        **_TORQUE,
        description="contact friction at rest; without effect on any motion",
    ),
    Parameter(
        "Tst",
        lower=0.0,
        upper=1.0,
        typical=1e-2,
        **_TORQUE,
        description="contact friction that rises with speed",
    ),
    Parameter("T0", "s/rad", 0.05, 1e3, "log", description="rate at which Tst rises"),
)

#: Settings, never estimated.
SETTINGS = (
    Parameter(
        "eps1",
        "s",
        1.0,
        1e7,
        "log",
        free=False,
        description="smoothing of the bearing's dry friction",
    ),
    Parameter(
        "eps2",
        "s",
        1.0,
        1e7,
        "log",
        free=False,
        description="smoothing of the contact's dry friction",
    ),
    Parameter("reaction", "1", 1.0, 2.0, free=False, description="factor of M_T in (16a)"),
)

#: Nuisances: what a rig has and nobody asks about.
NUISANCES = (
    # twice the circle, so that a phase near half a turn is no bound
    Parameter(
        "phase", "rad", -2.0 * np.pi, 2.0 * np.pi, typical=0.1, description="drive phase at t = 0"
    ),
    Parameter("gain", "rad per reading", -1e6, 1e6, description="gain of the measured drive"),
    Parameter(
        "level",
        "rad",
        -1e6,  # as wide as its gain: readings may be counts, far from zero
        1e6,
        typical=0.1,
        description="rest position, as read, under a measured drive",
    ),
    Parameter(
        "preload",
        "rad",
        -7.0,
        7.0,
        typical=0.1,
        description="winding of the spring at rest, under a measured drive",
    ),
    Parameter("zero1", "rad", -7.0, 7.0, typical=0.01, description="zero of phi1"),
    Parameter(
        "zero2", "rad", -7.0, 7.0, typical=0.1, scope="recording", description="zero of phi2"
    ),
)

DEFAULT_EPS = 5.0e4  # s; its error, 0.1 mrad, is below a noise of 1 mrad
SHARPEST_EPS = 1.0e7  # s; below it in ten thousand samples together, too
PAPER_EPS = 1.0e3  # s, as printed

BY_NAME = {p.name: p for p in (*BASE, *SETTINGS, *NUISANCES)}
