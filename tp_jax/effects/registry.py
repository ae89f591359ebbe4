"""Which effects there are: every class in this package, those installed, those registered."""

import functools
import importlib
import importlib.metadata
import pkgutil

from tp_jax.effects.base import CHANNELS, HOOKS, Effect

_PLAIN = {"base", "registry"}
_registered: dict[str, Effect] = {}


@functools.cache
def _built_in() -> dict[str, Effect]:
    package = importlib.import_module("tp_jax.effects")
    found: dict[str, Effect] = {}
    for info in pkgutil.iter_modules(package.__path__):
        if info.name in _PLAIN:
            continue
        module = importlib.import_module(f"tp_jax.effects.{info.name}")
        for value in vars(module).values():
            own = isinstance(value, type) and value.__module__ == module.__name__
            if own and issubclass(value, Effect) and value.id:
                found[value.id] = _checked(value())
    for entry in importlib.metadata.entry_points(group="tp_jax.effects"):
        effect = entry.load()()
        found[effect.id] = _checked(effect)
    return found


def _checked(effect: Effect) -> Effect:
    """The effect, if its class says all that is needed.

    Raises:
        ValueError: naming what is missing.
    """
    name = type(effect).__name__
    if not effect.id.isidentifier():
        raise ValueError(f"Effect {name} must have an identifier as `id`, but has {effect.id!r}.")
    if effect.location not in CHANNELS:
        raise ValueError(f"Effect {effect.id} must have a location of {sorted(CHANNELS)}.")
    if effect.hook not in HOOKS:
        raise ValueError(f"Effect {effect.id} must have a hook of {HOOKS}.")
    if type(effect).increment is Effect.increment:
        raise ValueError(f"Effect {effect.id} must define increment(self, m, ...).")
    if not effect.amplitudes:
        raise ValueError(f"Effect {effect.id} must have at least one amplitude.")
    return effect


def register(effect: type[Effect] | Effect) -> type[Effect] | Effect:
    """Adds an effect of one's own to the catalogue; usable as a class decorator.

    Raises:
        ValueError: if the class lacks an id, location, hook, amplitude or increment, or if its id
            is taken.
    """
    instance = effect() if isinstance(effect, type) else effect
    if instance.id in _built_in():
        raise ValueError(f"Effect {instance.id!r} is in the catalogue already; choose another id.")
    _registered[instance.id] = _checked(instance)
    return effect


def unregister(id: str) -> None:
    """Takes an effect that was registered out again."""
    _registered.pop(id, None)


def catalogue() -> dict[str, Effect]:
    """All effects by id, in alphabetical order."""
    return dict(sorted({**_built_in(), **_registered}.items()))


def get(id: str) -> Effect:
    """One effect by id.

    Raises:
        KeyError: if there is none of that name; the message lists those there are.
    """
    effects = catalogue()
    if id not in effects:
        raise KeyError(f"There is no effect {id!r}, choose one of: {', '.join(effects)}.")
    return effects[id]
