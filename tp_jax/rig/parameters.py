"""Numbers of a virtual rig."""

import dataclasses
import math

import numpy as np

from tp_jax.errors import InputError


@dataclasses.dataclass(frozen=True)
class RigParameters:
    """Parameters of a rig.

    Attributes:
        B1: moment of inertia of the column [kg m^2].
        B2: moment of inertia of the rider [kg m^2]; 0: there is no rider, the column stands alone.
        k: stiffness of the spring [N m/rad].
        A: amplitude of the drive [rad].
        c1: viscous friction of the bearing [N m s/rad].
        M1: dry friction of the bearing [N m].
        Tv: viscous friction of the contact [N m s/rad].
        Ts1: dry friction of the contact at rest [N m].
        Tst: what the contact's dry friction gains with speed [N m].
        T0: how soon it gains it [s/rad].

    Raises:
        InputError: one of them is no finite number, or cannot be.
    """

    B1: float = 1.2e-3
    B2: float = 5.0e-4
    k: float = 0.45
    A: float = 0.18
    c1: float = 2.2e-3
    M1: float = 5.0e-3
    Tv: float = 2.5e-4
    Ts1: float = 1.25e-2
    Tst: float = 2.5e-3
    T0: float = 4.0

    def __post_init__(self):
        for name, value in dataclasses.asdict(self).items():
            least = "above zero" if name in ("B1", "k") else "zero or more"
            if not math.isfinite(value) or value < 0.0 or (least == "above zero" and value == 0.0):
                raise InputError(f"The rig's {name} must be {least}, but is {value:g}.")

    @property
    def has_rider(self) -> bool:
        """True if a second body rides on the column."""
        return self.B2 > 0.0

    @property
    def natural_frequency(self) -> float:
        """Natural frequency of the column without its rider [rad/s]."""
        return math.sqrt(self.k / self.B1)

    def scaled(self, rng: np.random.Generator, spread: float) -> "RigParameters":
        """A rig like this one: every number times one of its own, uniform in 1 ± spread."""
        return RigParameters(
            **{
                name: value * float(rng.uniform(1.0 - spread, 1.0 + spread))
                for name, value in dataclasses.asdict(self).items()
            }
        )


#: The size of a laboratory stand.
BENCH = RigParameters()
