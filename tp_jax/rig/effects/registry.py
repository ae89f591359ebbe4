"""The list of all effects that can be hidden."""

import functools
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType, ModuleType

from tp_jax.errors import InputError
from tp_jax.recordings.faults import nearest
from tp_jax.rig.effects import bearing, clock, column, contact, drive, sensors, spring
from tp_jax.rig.effects.base import Effect, Hidden

FAMILIES: tuple[ModuleType, ...] = (drive, spring, bearing, contact, column, sensors, clock)
_registered: dict[str, Effect] = {}


def register(family: ModuleType) -> None:
    """Adds every effect of a module, so that a rig can hide effects that this package lacks.

    Args:
        family: its classes that are an `Effect` with an `id` are added; those that were added
            before stay.

    Raises:
        ValueError: an id is taken by another class.
    """
    known = catalogue()
    for id, effect in _effects_of(family).items():
        if id in known and type(known[id]) is not type(effect):
            raise ValueError(f"The rig has an effect {id!r} already; choose another id.")
        _registered.setdefault(id, effect)


def catalogue() -> Mapping[str, Effect]:
    """id -> effect, those of this package and those registered, by their names."""
    return MappingProxyType(dict(sorted({**_built_in(), **_registered}.items())))


@functools.cache
def _built_in() -> dict[str, Effect]:
    return {id: effect for family in FAMILIES for id, effect in _effects_of(family).items()}


def _effects_of(family: ModuleType) -> dict[str, Effect]:
    return {
        value.id: value()
        for value in vars(family).values()
        if isinstance(value, type) and issubclass(value, Effect) and value.id
    }


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
