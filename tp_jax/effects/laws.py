"""Laws that nobody wrote down: a smooth curve at a place of the rig, over one quantity.

Each is an effect like those of the catalogue: it has a place (a friction, the spring, the column, a
sensor, the drive) and an argument (an angle, a speed, a load, time), and its amplitudes are the
coefficients of Chebyshev polynomials over the values that the recordings visit, in units of the
place's typical size. Smoothness is the prior: a coefficient of degree n is expected within 1/n of
the first one's size. A term that a parameter of the model is already (the constant part of a
friction) is left out.

A compiled program carries `AnyLaw`, in which place and argument are numbers: one program serves all
laws, where one for each would take minutes to compile.

Laws are no part of `catalogue()`: a diagnosis asks for them only where no formula explains the gap
(`tp_jax.gap.learned`).

Source: Chebyshev series: Trefethen (2013), Approximation Theory and Approximation Practice, ch. 3
and 7.
"""

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp

from tp_jax.effects.base import Amplitude, Effect, Shape, change_of_friction
from tp_jax.model.arrays import AnyArray
from tp_jax.model.motion import Motion

DEGREE = 12
"""Degree of the polynomials: by least squares they follow a sine of two periods within .0014 of its
size, and |x| within a twentieth at its kink, a hundredth on average. One call of the engine takes
sixteen columns."""


@dataclasses.dataclass(frozen=True)
class Argument:
    """A quantity over which a law is a curve.

    Attributes:
        symbol: in tables and figures. unit: SI unit.
        of: its value at one instant.
        sided: whether it is never negative, so that its curve begins at zero.
    """

    symbol: str
    unit: str
    of: Callable[[Motion], Any]
    sided: bool = False


ARGUMENTS = {
    "phi1": Argument("φ1", "rad", lambda m: m.phi1),
    "phi2": Argument("φ2", "rad", lambda m: m.phi2),
    "v1": Argument("|φ̇1|", "rad/s", lambda m: jnp.abs(m.v1), True),
    "v2": Argument("|φ̇2|", "rad/s", lambda m: jnp.abs(m.v2), True),
    "load": Argument("|M_F|", "N m", lambda m: jnp.abs(m.k * m.wound), True),
    "d": Argument("f − φ1", "rad", lambda m: m.wound),
    "t": Argument("s", "1", lambda m: m.s),
    "theta": Argument("θ", "rad", lambda m: jnp.mod(m.theta, 2.0 * jnp.pi)),
}


@dataclasses.dataclass(frozen=True)
class Place:
    """Place where a law acts, and what its curve is.

    Attributes:
        location, hook: of the effect. unit: of the curve. size: typical size of the curve.
        formula: with the place of the curve.
        times: by what the curve is multiplied to give what is added at the hook.
        per_inertia: whether the curve's unit is that of `size` times B1.
        friction: whether the curve is the relative change of a friction, which stays positive.
        rider: whether it makes no sense without a second body.
        remedy, by_hand: of an effect.
    """

    location: str
    hook: str
    unit: str
    size: float
    formula: str
    times: Callable[[Motion], Any]
    friction: bool = False
    per_inertia: bool = False
    rider: bool = False
    remedy: str = ""
    by_hand: str = ""


PLACES = {
    "bearing_dry": Place(
        "bearing",
        "bearing",
        "1",
        0.2,
        "M1 S (1 + {})",
        lambda m: m.bearing_dry,
        friction=True,
        remedy="put the curve into the model, and look at the bearing where it is highest",
        by_hand="turn the column slowly over the whole range, and feel where it is stiff",
    ),
    "contact_dry": Place(
        "contact",
        "contact",
        "1",
        0.2,
        "(Ts1 S + Tst term)(1 + {})",
        lambda m: m.contact_dry,
        friction=True,
        rider=True,
        remedy="put the curve into the model, and look at the contact where it is highest",
        by_hand="slide the rider slowly by hand, and feel where it is held",
    ),
    "spring": Place(
        "spring",
        "spring",
        "rad",
        0.02,
        "k (d + {})",
        lambda m: m.k,
        remedy="put the curve into the model, or use the spring over a part of its range only",
        by_hand="wind the spring in ten steps against a balance, and draw torque over angle",
    ),
    "column": Place(
        "column",
        "column",
        "N m",
        2.0,
        "column torque + {}",
        lambda m: m.B1,
        per_inertia=True,
        remedy="put the curve into the model, and look for what touches or pulls the column there",
        by_hand="hold the column with a balance at ten angles, the spring taken off",
    ),
    "drive": Place(
        "drive",
        "drive",
        "1",
        0.05,
        "f = A (sin theta + {})",
        lambda m: m.A,
        remedy="measure the arm's angle, and give it as drive",
        by_hand="turn the motor by hand in steps of 30 degrees, and note the arm's angle",
    ),
    "sensor1": Place(
        "sensor1",
        "sensor1",
        "rad",
        0.02,
        "y1 = phi1 + {}",
        lambda _: 1.0,
        remedy="calibrate sensor 1 over the whole range, as tp-jax calibrate does",
        by_hand="turn the column to ten known angles, and draw reading over angle",
    ),
    "sensor2": Place(
        "sensor2",
        "sensor2",
        "rad",
        0.02,
        "y2 = phi2 + {}",
        lambda _: 1.0,
        rider=True,
        remedy="calibrate sensor 2 over the whole range, as tp-jax calibrate does",
        by_hand="turn the rider to ten known angles, and draw reading over angle",
    ),
}

FAMILIES = (
    "bearing_dry.load",
    "bearing_dry.phi1",
    "bearing_dry.t",
    "bearing_dry.v1",
    "column.phi1",
    "contact_dry.phi2",
    "contact_dry.t",
    "contact_dry.v2",
    "drive.theta",
    "sensor1.phi1",
    "sensor2.phi2",
    "spring.d",
)
"""Place and argument of every law."""

NAMES = tuple(f"c{n}" for n in range(1, DEGREE + 1))
"""Coefficients, the first degree first."""

MIDDLE, HALF = "middle", "half"
"""Shape constants: middle and half width of the argument's range."""


def curve(x: Any, middle: Any, half: Any, coefficients: Sequence[Any] | AnyArray) -> Any:
    """Values of a curve, in units of its place's size.

    Args:
        x: argument. middle, half: of its range; beyond it the curve stays as at the end.
        coefficients: `DEGREE` of them.
    """
    u = jnp.clip((x - middle) / half, -1.0, 1.0)
    # Polynomial by polynomial and not by Clenshaw's recurrence, which takes as many operations: the
    # derivative by a coefficient is then a number that is there already.
    before, now, total = 1.0, u, coefficients[0] * u
    for c in coefficients[1:]:
        before, now = now, 2.0 * u * now - before
        total = total + c * now
    return total


def _added(place: Place, m: Motion, y: Any) -> Any:
    """Returns what a curve adds at its hook."""
    y = place.size * y
    return place.times(m) * (change_of_friction(y) if place.friction else y)


_BOUND = 20.0
"""Bound of a coefficient, in units of the place's size: seven standard deviations of the prior."""

_AMPLITUDES = tuple(
    Amplitude(name, "1", 1.0 / n, -_BOUND, _BOUND) for n, name in enumerate(NAMES, start=1)
)


class AnyLaw(Effect):
    """All laws in one formula, for a compiled program: which of them it is, is data.

    The weights of places and arguments are zero but for one of each; `Law.constants` has them.
    """

    id = "law"
    location = hook = "column"
    amplitudes = _AMPLITUDES
    formula = "a curve over one quantity, at one place"

    shapes = (
        Shape(MIDDLE, "1", (0.0,)),
        Shape(HALF, "1", (1.0,)),
        *(Shape(f"at_{place}", "1", (0.0,)) for place in PLACES),
        *(Shape(f"over_{argument}", "1", (0.0,)) for argument in ARGUMENTS),
    )

    @property
    def hooks(self) -> tuple[str, ...]:
        """Returns the hooks of all places."""
        return tuple(place.hook for place in PLACES.values())

    def increment(self, m, middle, half, **numbers):  # type: ignore[override]
        """Returns what the law adds at the hook that is asked (`Motion.hook`)."""
        if not hasattr(m, "curve"):  # at the first hook; it is the same at all
            x = sum(numbers[f"over_{n}"] * each.of(m) for n, each in ARGUMENTS.items())
            m.curve = curve(x, middle, half, [numbers[n] for n in NAMES])
        name = next(n for n, place in PLACES.items() if place.hook == m.hook)
        return numbers[f"at_{name}"] * _added(PLACES[name], m, m.curve)


class Law(Effect):
    """A curve over one quantity, at one place.

    Attributes:
        id: family, as "bearing_dry.phi1". place, argument: its parts.
        constants: weights that make `AnyLaw` this one, in whose slots its numbers stand.
    """

    slots = AnyLaw.id
    amplitudes = _AMPLITUDES

    def __init__(self, family: str):
        place, _, argument = family.partition(".")
        self.id = family  # type: ignore[misc]
        self.place, self.argument = PLACES[place], ARGUMENTS[argument]
        self.location, self.hook = self.place.location, self.place.hook  # type: ignore[misc]
        self.shapes = (  # type: ignore[misc]
            Shape(MIDDLE, self.argument.unit, (0.0,)),
            Shape(HALF, self.argument.unit, (1.0,)),
        )
        self.constants = {  # type: ignore[misc]
            **{f"at_{name}": float(name == place) for name in PLACES},
            **{f"over_{name}": float(name == argument) for name in ARGUMENTS},
        }
        needs = {"rider"} if self.place.rider else set()
        self.needs = frozenset(needs | ({"sine"} if argument == "theta" else set()))  # type: ignore[misc]
        self.uses_phi2 = argument == "phi2"  # type: ignore[misc]
        self.drifts = argument == "t"  # type: ignore[misc]
        self.formula = self.place.formula.format(f"curve of {self.argument.symbol}")  # type: ignore[misc]
        self.looks_like = "nothing in the catalogue"  # type: ignore[misc]
        self.source = "learned from the recordings"  # type: ignore[misc]
        self.remedy, self.by_hand = self.place.remedy, self.place.by_hand  # type: ignore[misc]

    def increment(self, m, middle, half, **coefficients):  # type: ignore[override]
        """See the class."""
        y = curve(self.argument.of(m), middle, half, [coefficients[n] for n in NAMES])
        return _added(self.place, m, y)


@functools.cache
def laws() -> dict[str, Law]:
    """All laws by family."""
    return {family: Law(family) for family in FAMILIES}
