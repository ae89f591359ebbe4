"""Printed form of an object: its numbers and names, and of arrays only how large they are."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

MOST = 6
"""Entries of a list or a table that are printed."""


def short(thing: Any) -> str:
    """A line for a dataclass, or what is in one; what has a line of its own keeps it.

    Example:
        >>> short({"x": np.zeros((3, 100)), "name": "a"})
        "{'x': array(3, 100), 'name': 'a'}"
    """
    if isinstance(thing, np.ndarray):
        return f"array({', '.join(map(str, thing.shape))})" if thing.size > 1 else str(thing)
    if isinstance(thing, Mapping):
        pairs = [f"{key!r}: {short(value)}" for key, value in list(thing.items())[:MOST]]
        return f"{{{', '.join(pairs)}{_more(thing)}}}"
    if isinstance(thing, list | tuple | range) and type(thing) in (list, tuple, range):
        begin, end = "()" if isinstance(thing, tuple) else "[]"
        return begin + ", ".join(map(short, thing[:MOST])) + _more(thing) + end
    if isinstance(thing, str) and len(thing) > 80:
        return repr(f"{thing[:77]}...")
    return repr(thing)


def short_fields(self: Any) -> str:
    """Lists a dataclass's fields for `__repr__`, without those that are as they are by default."""
    told = []
    for field in dataclasses.fields(self):
        value = getattr(self, field.name)
        default = field.default
        if field.default_factory is not dataclasses.MISSING:
            default = field.default_factory()
        plain = default is not dataclasses.MISSING and not isinstance(value, np.ndarray)
        if not (plain and value == default):
            told.append(f"{field.name}={short(value)}")
    return f"{type(self).__name__}({', '.join(told)})"


def _more(thing: Any) -> str:
    return f", ... {len(thing)} in all" if len(thing) > MOST else ""
