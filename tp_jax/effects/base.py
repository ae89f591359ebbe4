"""Base of all effects: formulas that add to one quantity of the model, null at amplitude zero.

An effect is one class in one file. It names where it acts and what its amplitudes and shape
constants are, and gives the increment:

    class SpringAsymmetry(Effect):
        id = "spring_asymmetry"
        location = "spring"
        hook = "spring"
        amplitudes = (Amplitude("a", "1", typical=0.05),)

        def increment(self, m, a):
            return a * m.k * abs(m.d)

Amplitude zero must be an interior point (or the edge of a physical range) with a derivative that
is not zero there, since all effects are judged from one linearisation at null.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from tp_jax.model.motion import Motion

#: Location to the channel through which it acts on the recordings.
CHANNELS = {
    "drive": "column",
    "spring": "column",
    "bearing": "column",
    "column": "column",
    "base": "column",
    "contact": "contact",
    "sensor1": "sensor1",
    "sensor2": "sensor2",
    "clock": "clock",
    "model": "column",
}

HOOKS = (
    "clock",
    "phase",
    "drive",
    "spring",
    "bearing",
    "contact",
    "column",
    "base",
    "sensor1",
    "sensor2",
)


FROZEN = -1.0
"""Least value of a relative change of a friction: below, it would drive the motion."""


def change_of_friction(x: Any) -> Any:
    """Returns a relative change of a friction, that friction never drives the motion.

    Args:
        x: the change by a formula or a curve, which may go below `FROZEN`.
    """
    return jnp.maximum(x, FROZEN)


@dataclasses.dataclass(frozen=True)
class Amplitude:
    """One amplitude of an effect, null at zero.

    Attributes:
        name: argument of `increment`.
        unit: SI unit.
        typical: a size that is noticeable and not absurd; scales the estimation.
        lower, upper: physical range.
        per_recording: one value for each recording instead of one for the campaign.
    """

    name: str
    unit: str
    typical: float = 0.1
    lower: float = -np.inf
    upper: float = np.inf
    per_recording: bool = False


@dataclasses.dataclass(frozen=True)
class Shape:
    """A shape constant: profiled on a grid, since the null does not depend on it.

    A continuous one is refined from the best grid point once its effect has an amplitude.
    """

    name: str
    unit: str
    grid: tuple[float, ...]
    continuous: bool = False


class Effect:
    """Base class of all effects; see the module's docstring for an example.

    Class attributes:
        id: name in results, as in the catalogue.
        location: place in the rig; decides the channel (`CHANNELS`).
        hook: the quantity `increment` adds to: clock [1], phase [rad], drive [rad], spring
            [N m], bearing [N m], contact [N m], column [N m], base (its acceleration) [rad/s^2],
            sensor1 [rad], sensor2 [rad].
        amplitudes, shapes: see `Amplitude` and `Shape`.
        needs: conditions a campaign must meet: "rider" (two angles), "sine" (a commanded drive),
            "measured" (a measured drive), "commanded" (no measured one), "several" (more than one
            recording), "inertias" (B1 and B2 given).
        uses_phi1: the increment depends on phi1 itself, so that its zero matters beyond the rest
            position; a nuisance where the drive is measured (with a sine it is one anyway).
        uses_winding: the increment depends on the spring's winding itself, so that it matters where
            the spring is relaxed; a nuisance where the drive is measured.
        uses_phi2: the increment depends on phi2 itself, so that its zero becomes a nuisance.
        relative: the parameter whose part the amplitude of each recording is, where that is so:
            what they have in common is then the parameter's, and only their differences matter.
        drifts: whether it changes with the time within a run, the same way in every run: one run
            cannot show that another would.
        n_states: number of states of its own, each in rad, zero where a run begins at rest.
        slots: name under which a layout has its numbers, where that is not its id: laws share
            those of one (`laws.AnyLaw`); constants: what stands there for it besides.
        reads_later: the amplitude [s] by which it has a measured drive read later, if it does;
            its increment is then `m.later` of it.
        formula, source, looks_like: for people.
        says: what happens, as a clause behind "the cause:"; an effect of the catalogue has it in
            `tp_jax.report.words`, which a report needs without JAX.
        remedy: what to do about it at the rig. by_hand: how to see there by hand (weigh, time,
            turn, swap) whether it is so. Both begin with a verb and end without a full stop.
    """

    id: ClassVar[str] = ""
    location: ClassVar[str] = ""
    hook: ClassVar[str] = ""
    amplitudes: ClassVar[tuple[Amplitude, ...]] = ()
    shapes: ClassVar[tuple[Shape, ...]] = ()
    needs: ClassVar[frozenset[str]] = frozenset()
    uses_phi1: ClassVar[bool] = False
    uses_winding: ClassVar[bool] = False
    uses_phi2: ClassVar[bool] = False
    relative: ClassVar[str] = ""
    drifts: ClassVar[bool] = False
    n_states: ClassVar[int] = 0
    slots: ClassVar[str] = ""
    constants: ClassVar[Mapping[str, float]] = {}
    reads_later: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    source: ClassVar[str] = ""
    looks_like: ClassVar[str] = ""
    says: ClassVar[str] = ""
    remedy: ClassVar[str] = ""
    by_hand: ClassVar[str] = ""

    def increment(self, m: Motion, **values: Any) -> Any:
        """Returns what the effect adds to its quantity at one instant.

        Args:
            m: motion and torques of the instant; filled up to the effect's hook.
            values: amplitudes and shape constants by name.
        """
        raise NotImplementedError(f"The effect {self.id} must define increment(m, ...).")

    def rates(self, m: Motion, **values: Any) -> tuple:  # noqa: ARG002
        """Derivatives of the effect's own states; `m.z` holds them."""
        return ()

    def past(self, m: Motion, **values: Any) -> tuple:  # noqa: ARG002
        """The effect's own states along a motion: what it remembers where a window begins.

        Args:
            m: a row of instants (n,) in the order of time, as measured (smoothed) or as fitted.
            values: amplitudes and shape constants by name; the amplitudes do not matter.

        Returns:
            Each state (n,), zero at first.
        """
        return (0.0 * m.phi1,) * self.n_states

    @property
    def channel(self) -> str:
        """column, contact, sensor1, sensor2 or clock."""
        return CHANNELS[self.location]

    def resolved(self, omega: float, step: float) -> bool:  # noqa: ARG002
        """True where samples `step` [s] apart can show the effect at a drive frequency [rad/s]."""
        return True

    @property
    def about_rider(self) -> bool:
        """True where it makes no sense without a second body."""
        return "rider" in self.needs or self.hook in ("contact", "sensor2")

    def qualified(self, name: str) -> str:
        """Name of one of its amplitudes or constants among all parameters."""
        return f"{self.slots or self.id}.{name}"

    @property
    def hooks(self) -> tuple[str, ...]:
        """The quantities that it adds to: one, but for `laws.AnyLaw`."""
        return (self.hook,)


class Applied(eqx.Module):
    """An effect with numbers: what a pendulum carries in its `terms`."""

    effect: Effect = eqx.field(static=True)
    values: dict[str, Any]

    @property
    def hook(self) -> str:
        """Quantity the effect adds to."""
        return self.effect.hook

    @property
    def hooks(self) -> tuple[str, ...]:
        """All quantities the effect adds to."""
        return self.effect.hooks

    @property
    def n_states(self) -> int:
        """Number of its own states."""
        return self.effect.n_states

    def increment(self, m: Motion) -> Any:
        """Returns what it adds."""
        return self.effect.increment(m, **self.values)

    def rates(self, m: Motion) -> tuple:
        """Derivatives of its own states."""
        return self.effect.rates(m, **self.values)

    def past(self, m: Motion) -> tuple:
        """Its own states along a motion."""
        return self.effect.past(m, **self.values)
