"""Effects that can be hidden in a virtual rig: one class for each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tp_jax.rig.hooks import Hooks
from tp_jax.rig.parameters import BENCH, RigParameters


@dataclass(frozen=True)
class Run:
    """Data of a run that an effect may need when it is installed.

    Attributes:
        hooks: where it takes hold.
        parameters: of the rig.
        omega: of the drive [rad/s], None where the motor stands.
        duration: [s].
        rng: for whatever is random.
        shapes: shape constants of the effect by name.
    """

    hooks: Hooks
    parameters: RigParameters
    omega: float | None
    duration: float
    rng: np.random.Generator
    shapes: Mapping[str, float]


@dataclass(frozen=True)
class Draw:
    """An effect as drawn for a rig.

    Attributes:
        sizes: its amplitudes, in their order.
        shapes: "id.name" -> shape constant.
    """

    sizes: tuple[float, ...]
    shapes: Mapping[str, float]


@dataclass(frozen=True)
class Dice:
    """Chance, and the rig for which sizes are drawn."""

    rng: np.random.Generator
    rig: RigParameters

    def between(self, low: float, high: float) -> float:
        """A number from `low` to `high`."""
        return float(self.rng.uniform(low, high))

    def signed(self, low: float, high: float) -> float:
        """A number from `low` to `high`, of either sign."""
        return self.between(low, high) * self.one_of(-1.0, 1.0)

    def direction(self, low: float, high: float) -> tuple[float, float]:
        """Two numbers of a common size from `low` to `high`, in any direction."""
        size, angle = self.between(low, high), self.between(0.0, 2.0 * math.pi)
        return size * math.cos(angle), size * math.sin(angle)

    def one_of(self, *values: float) -> float:
        """One of some numbers."""
        return float(self.rng.choice(values))

    def whole(self, low: int, high: int) -> float:
        """A whole number from `low` to `high`, both included."""
        return float(self.rng.integers(low, high + 1))


class Effect:
    """Base class; all is said in class attributes and two methods, `install` and `drawn`.

    Attributes:
        id: its name. formula: what it does. unit: of each amplitude.
        channel: column, contact, sensor1, sensor2 or clock, where it shows.
        location: drive, spring, bearing, contact, column, base, sensor1, sensor2, clock or model.
        amplitudes: their names, zero for no effect.
        shapes: name -> usual value.
        per_run: the size is a spread, out of which every run gets values of its own.
        relative: only the differences between runs matter, a campaign's values have mean zero.
        needs_rider: it makes no sense on a column alone.
        stage: those of a higher one take hold later, and see what the others made.
        in_catalogue: whether the package's catalogue has it; if not, the diagnosis can but say in
            which channel it is.
    """

    id: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    unit: ClassVar[tuple[str, ...]] = ("1",)
    channel: ClassVar[str] = ""
    location: ClassVar[str] = ""
    amplitudes: ClassVar[tuple[str, ...]] = ("a",)
    shapes: ClassVar[Mapping[str, float]] = {}
    per_run: ClassVar[bool] = False
    relative: ClassVar[bool] = False
    needs_rider: ClassVar[bool] = False
    stage: ClassVar[int] = 0
    in_catalogue: ClassVar[bool] = True

    def install(self, run: Run, *sizes: float) -> None:
        """Takes hold of the rig for one run; never called with all sizes zero."""
        raise NotImplementedError(f"The effect {self.id} must define install(run, ...).")

    def drawn(self, dice: Dice) -> Draw:
        """Sizes and shape constants that a rig might well have."""
        raise NotImplementedError(f"The effect {self.id} must define drawn(dice).")

    def draw(self, rng: np.random.Generator, parameters: RigParameters = BENCH) -> Draw:
        """Random sizes and shape constants that a rig with these numbers might well have."""
        return self.drawn(Dice(rng, parameters))

    def draw_run(self, rng: np.random.Generator, sizes: Sequence[float]) -> tuple[float, ...]:  # noqa: ARG002
        """Values of one run, from the sizes; for effects with `per_run` only."""
        return tuple(sizes)

    def _drawn(self, *sizes: float, **shapes: float) -> Draw:
        return Draw(tuple(sizes), {f"{self.id}.{name}": value for name, value in shapes.items()})


@dataclass(frozen=True)
class Hidden:
    """An effect with its sizes and shape constants (by name)."""

    effect: Effect
    sizes: tuple[float, ...]
    shapes: Mapping[str, float]

    def draw_run(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Values of one run."""
        return self.effect.draw_run(rng, self.sizes)

    def install(self, hooks, parameters, values, omega, duration, rng) -> None:
        """Takes hold of the rig for one run; nothing at all at size zero."""
        if any(values):
            self.effect.install(Run(hooks, parameters, omega, duration, rng, self.shapes), *values)
