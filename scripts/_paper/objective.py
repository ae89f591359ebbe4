"""Equation (17) and Listing 1: eleven numbers in, one out."""

import dataclasses

import numpy as np

from tp_jax.model import presets
from tp_jax.model.parameters import PAPER_EPS
from tp_jax.model.pendulum import PRINTED_REACTION
from tp_jax.simulation.solve import Trajectory, simulate

#: x(1) to x(11) of Listing 1, where M is our M1.
ORDER = ("B1", "B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Ts2", "Tst", "T0")

#: Where Section 5.2 starts (Listing 1).
LISTING_START = (1.0,) * 10 + (100.0,)

#: A run that takes more steps than this has gone astray: negative masses, springs that push.
MAX_STEPS = 20_000

TOLERANCE = 1e-8  # rad, of a step


def motion(x, omega: float, ts: np.ndarray) -> Trajectory:
    """The printed model from rest.

    Args:
        x: (11,) numbers in the order of Listing 1.
        omega: of the drive [rad/s].
        ts: (n,) times [s].
    """
    numbers = dict(zip(ORDER, np.asarray(x, float).tolist(), strict=True))
    model = presets.double_pendulum(
        **numbers, omega=omega, eps=PAPER_EPS, reaction=PRINTED_REACTION
    )
    return simulate(model, ts, tolerance=TOLERANCE, max_steps=MAX_STEPS)


def of_preset(name: str) -> np.ndarray:
    """A preset's numbers in the order of Listing 1 (11,)."""
    values = presets.values(name)
    return np.array([values[n] for n in ORDER])


@dataclasses.dataclass
class Objective:
    """y of (17) [rad^2] against two recorded angles.

    Attributes:
        ts: (n,) times [s]. phi1, phi2: (n,) recorded angles [rad]. omega: of the drive [rad/s].
        evaluations: how often it was called; history: y of each call.
    """

    ts: np.ndarray
    phi1: np.ndarray
    phi2: np.ndarray
    omega: float
    evaluations: int = 0
    history: list[float] = dataclasses.field(default_factory=list)

    def __call__(self, x) -> float:
        """Infinite where the model cannot be followed to the end."""
        y = self.of(motion(x, self.omega, self.ts))
        self.evaluations += 1
        self.history.append(y)
        return y

    def of_x(self, x) -> float:
        """y, not counted."""
        return self.of(motion(x, self.omega, self.ts))

    @property
    def of_rest(self) -> float:
        """y of a rig that does not move: what there is to explain."""
        return 0.5 * float(np.mean(self.phi1**2) + np.mean(self.phi2**2))

    def of(self, m: Trajectory) -> float:
        """y of a motion."""
        with np.errstate(over="ignore", invalid="ignore"):
            one = np.mean((np.asarray(m.phi1) - self.phi1) ** 2)
            two = np.mean((np.asarray(m.phi2) - self.phi2) ** 2)
            y = 0.5 * float(one + two)
        return y if np.isfinite(y) else np.inf

    def fresh(self) -> "Objective":
        """The same with nothing counted yet."""
        return Objective(self.ts, self.phi1, self.phi2, self.omega)
