"""Values of parameters that a search can work with: refused in one sentence where they cannot be.

Numbers far outside what a rig can have do not make a search fail; they overflow, or make it go on
for hours. Nothing here needs JAX, so that an argument is judged before anything is loaded.
"""

from collections.abc import Mapping, Sequence

from tp_jax.errors import InputError
from tp_jax.model.parameters import BASE, Parameter

BEYOND = 1e3
"""Factor by which a value may lie beyond a parameter's own bounds: these are for usual rigs."""

MOST_SPREAD = 100.0
"""Factor by which a global analysis may vary parameters: ten thousand from end to end."""


def check_names(names: Sequence[str]) -> None:
    """Raises InputError where one is no parameter."""
    known = [p.name for p in BASE]
    for name in names:
        if name not in known:
            raise InputError(f"There is no parameter {name!r}, choose one of: {', '.join(known)}.")


def span(spec: Parameter, B1: float | None) -> tuple[float, float]:
    """Least and largest value [SI] of a parameter on a rig whose column has the inertia B1.

    Without B1 [kg m^2] it is taken to be 1, as in a fit.
    """
    if spec.name == "B1":  # the rig's own scale
        return spec.lower / BEYOND, spec.upper * BEYOND * BEYOND
    own = spec.scaled(1.0 if B1 is None else B1)
    return own.lower / BEYOND, own.upper * BEYOND


def check_values(
    fix: Mapping[str, float],
    bound: Mapping[str, tuple[float, float]] | None = None,
    B1: float | None = None,
) -> None:
    """Sees that parameters can be held at some values and kept within others.

    Args:
        fix: values by name, SI units.
        bound: (lower, upper) by name, SI units.
        B1: inertia of the column [kg m^2] where `fix` does not say it; None: not known.

    Raises:
        InputError: in one sentence, which is not possible.
    """
    bound = bound or {}
    check_names([*fix, *bound])
    specs = {p.name: p for p in BASE}
    if "B1" in fix:
        _check_value(specs["B1"], fix["B1"], B1)
        B1 = fix["B1"]
    for name, value in fix.items():
        if name in bound:
            raise InputError(f"Parameter {name} is fixed and bounded; one of the two must go.")
        _check_value(specs[name], value, B1)
    for name, (low, high) in bound.items():
        if not low < high:
            raise InputError(f"The bounds of {name} must rise, but are {low:g} and {high:g}.")
        if low < 0.0:
            raise InputError(f"Parameter {name} must not be negative, but its bound is {low:g}.")
        least, most = span(specs[name], B1)
        # a lower bound of zero says nothing, whatever the parameter
        if (low != 0.0 and low < least) or high < least or high > most:
            raise InputError(
                f"The bounds of {name} must lie between {least:g} and {most:g} {specs[name].unit}"
                f"{_on(specs[name], B1)}, but are {low:g} and {high:g}."
            )


def _check_value(spec: Parameter, value: float, B1: float | None) -> None:
    positive = spec.transform == "log" or spec.lower > 0.0
    if not value >= 0.0 or (value == 0.0 and positive):
        least = "above zero" if positive else "zero or more"
        raise InputError(f"Parameter {spec.name} must be {least}, but is fixed at {value:g}.")
    low, high = span(spec, B1)
    if not low <= value <= high:
        raise InputError(
            f"Parameter {spec.name} must lie between {low:g} and {high:g} {spec.unit}"
            f"{_on(spec, B1)}, but is fixed at {value:g}."
        )


def _on(spec: Parameter, B1: float | None) -> str:
    if not spec.per_inertia or spec.name == "B1":
        return ""
    return f" where B1 is {1.0 if B1 is None else B1:g} kg m^2"
