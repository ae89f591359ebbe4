"""Objects of the package's classes with those attributes alone that a test needs."""

from typing import Any, TypeVar

Kind = TypeVar("Kind")


def standing_in(kind: type[Kind], **attributes: Any) -> Kind:
    """Returns an object that was never made as its class makes one; any other attribute is missing.

    Properties of the class may be given too.
    """
    made = object.__new__(type(kind.__name__, (kind,), dict.fromkeys(attributes)))
    for name, value in attributes.items():
        object.__setattr__(made, name, value)
    return made
