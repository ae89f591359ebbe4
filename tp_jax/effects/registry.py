"""Registry of effects: every class in this package, those installed, those registered."""

import functools
import importlib
import importlib.metadata
import pkgutil
import warnings

from tp_jax.effects.base import CHANNELS, HOOKS, Effect
from tp_jax.effects.laws import laws
from tp_jax.effects.trial import tried
from tp_jax.errors import Notice

_PLAIN = {"base", "laws", "registry", "trial"}
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
        try:
            effect = _plugged_in(entry)
            if effect.id in found:
                raise ValueError(f"there is an effect {effect.id!r} already")
        except (Exception, SystemExit) as fault:  # whatever somebody else's module may raise
            warnings.warn(_left_out(entry, fault), Notice, stacklevel=2)
            continue
        found[effect.id] = effect
    return found


def _plugged_in(entry: importlib.metadata.EntryPoint) -> Effect:
    """The effect of an installed package.

    Raises:
        Exception: anything, since it is another's code that runs.
    """
    made = entry.load()()
    if not isinstance(made, Effect):
        raise TypeError(f"{entry.value} makes no tp_jax.effects.Effect, but {type(made).__name__}")
    tried(_checked(made))
    return made


def _left_out(entry: importlib.metadata.EntryPoint, fault: BaseException) -> str:
    package = f" of {entry.dist.name}" if entry.dist is not None else ""
    why = " ".join(f"{type(fault).__name__}: {fault}".split()).rstrip(".: ")
    return f"The effect plug-in {entry.name}{package} is left out ({why}); mend or uninstall it."


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
        ValueError: if the class lacks an id, location, hook, amplitude or increment, if its id is
            taken, or if its formula cannot be evaluated on a few motions.
    """
    instance = effect() if isinstance(effect, type) else effect
    if instance.id in _built_in():
        raise ValueError(f"Effect {instance.id!r} is in the catalogue already; choose another id.")
    tried(_checked(instance))
    _registered[instance.id] = instance
    return effect


def unregister(id: str) -> None:
    """Takes an effect that was registered out again."""
    _registered.pop(id, None)


def catalogue() -> dict[str, Effect]:
    """All effects by id, in alphabetical order."""
    return dict(sorted({**_built_in(), **_registered}.items()))


def get(id: str) -> Effect:
    """One effect by id: of the catalogue, or a law by its family (`laws`).

    Raises:
        KeyError: if there is none of that name; the message lists those there are.
    """
    effects = catalogue()
    if id in laws():
        return laws()[id]
    if id not in effects:
        raise KeyError(f"There is no effect {id!r}, choose one of: {', '.join(effects)}.")
    return effects[id]
