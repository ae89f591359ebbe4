"""Base classes of effects that the package's catalogue lacks."""

from typing import ClassVar

from tp_jax.rig.effects import Effect


class Outside(Effect):
    """An effect that the catalogue lacks.

    Attributes:
        cousin_of: the effect of the catalogue of which this is another formula, if it is one.
        family: "place.argument" of a law learned from data that would hold it, where it has one.
        rough_only: hidden in trials on rough rigs only.
    """

    in_catalogue = False
    cousin_of: ClassVar[str] = ""
    family: ClassVar[str] = ""
    rough_only: ClassVar[bool] = False


class Cousin(Outside):
    """The catalogue has the kind, but not this formula."""

    rough_only = True


def is_cousin(effect: Effect) -> bool:
    """True if the catalogue has the kind of an effect, but another formula of it."""
    return isinstance(effect, Outside) and bool(effect.cousin_of)
