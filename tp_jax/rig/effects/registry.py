"""The list of all effects that can be hidden."""

import functools
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType, ModuleType

from tp_jax.errors import InputError
from tp_jax.recordings.faults import nearest
from tp_jax.rig.effects import (
    bearing,
    clock,
    column,
    contact,
    cousins_bearing,
    cousins_column,
    cousins_contact,
    cousins_drive,
    cousins_sensors,
    cousins_spring,
    drive,
    outside_clock,
    outside_column,
    outside_contact,
    outside_sensors,
    sensors,
    spring,
)
from tp_jax.rig.effects.base import Effect, Hidden

FAMILIES: tuple[ModuleType, ...] = (
    drive, spring, bearing, contact, column, sensors, clock,
    outside_column, outside_contact, outside_sensors, outside_clock,
    cousins_drive, cousins_spring, cousins_bearing, cousins_contact, cousins_column,
    cousins_sensors,
)  # fmt: skip


@functools.cache
def catalogue() -> Mapping[str, Effect]:
    """id -> effect, those in the package's catalogue and those outside it, by their names."""
    found = {
        value.id: value()
        for family in FAMILIES
        for value in vars(family).values()
        if isinstance(value, type) and issubclass(value, Effect) and value.id
    }
    return MappingProxyType(dict(sorted(found.items())))


def hide(
    effects: Mapping[str, float | Sequence[float]], shapes: Mapping[str, float]
) -> tuple[Hidden, ...]:
    """Effects with their sizes, from what a user gives; see `VirtualRig`.

    Raises:
        InputError: in one sentence, what is wrong.
    """
    known = catalogue()
    for id in effects:
        if id not in known:
            near = nearest(id, known)
            mend = f"; did you mean {near}?" if near else f", choose from: {', '.join(known)}."
            raise InputError(f"There is no effect {id!r} to hide{mend}")
    constants = _constants(effects, shapes)
    hidden = [
        Hidden(known[id], _sizes(known[id], size), constants[id]) for id, size in effects.items()
    ]
    return tuple(sorted(hidden, key=lambda each: each.effect.stage))


def _sizes(effect: Effect, given: float | Sequence[float]) -> tuple[float, ...]:
    sizes = tuple(map(float, given)) if isinstance(given, Sequence) else (float(given),)
    names = effect.amplitudes
    if not 1 <= len(sizes) <= len(names):
        raise InputError(
            f"Effect {effect.id} takes {len(names)} sizes ({', '.join(names)}), not {len(sizes)}."
        )
    if not all(map(math.isfinite, sizes)):
        raise InputError(f"The size of effect {effect.id} must be finite, but is {given}.")
    return sizes + (0.0,) * (len(names) - len(sizes))


def _constants(
    ids: Mapping[str, object], shapes: Mapping[str, float]
) -> dict[str, dict[str, float]]:
    known = catalogue()
    constants = {id: dict(known[id].shapes) for id in ids}
    for key, value in shapes.items():
        id, _, name = key.partition(".")
        if id not in constants or name not in constants[id]:
            names = [f"{id}.{name}" for id in constants for name in constants[id]]
            raise InputError(
                f"There is no shape constant {key!r} of the effects hidden here; "
                f"there {'are: ' + ', '.join(names) if names else 'is none at all'}."
            )
        if not math.isfinite(value) or value <= 0.0:
            raise InputError(f"The shape constant {key} must be above zero, but is {value}.")
        constants[id][name] = float(value)
    return constants
