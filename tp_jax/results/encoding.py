"""Results as types and as JSON: the annotations of a type say how it is written, read and checked.

A field that was not given to a type's constructor is no key of its JSON, as with pydantic's
`exclude_unset`: a file that lacks it is written again as it was.
"""

import dataclasses
import math
import numbers
from collections.abc import Mapping
from functools import cache
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union, get_args, get_origin
from typing import get_type_hints as hints_of

from tp_jax.schemas import parts
from tp_jax.schemas.checking import LARGEST

Part = TypeVar("Part", bound="Record")

_UNFIT: Any = object()
_COUNTS = {2: "two", 4: "four"}
_PLAIN = {float: parts.NUMBER, int: parts.COUNT, str: parts.NAME, bool: parts.YES_OR_NO}


class Schema(dict[str, Any]):
    """JSON schema that a type is annotated with, beyond what it says itself."""

    __hash__ = object.__hash__  # type: ignore[assignment]


class Record:
    """A part of a result: a frozen dataclass that is an object in JSON."""

    if not TYPE_CHECKING:  # editors show the fields

        def __new__(cls, *args, **kwargs):
            made = super().__new__(cls)
            given = [each.name for each in dataclasses.fields(cls)][: len(args)]
            object.__setattr__(made, "_given", frozenset([*given, *kwargs]))
            return made

    def to_dict(self) -> dict[str, Any]:
        """The result as plain numbers, texts, lists and tables; SI units, angles in rad."""
        return {
            key: _encoded(getattr(self, name))
            for key, name, _ in _fields(type(self))
            if name in self._given  # type: ignore[attr-defined]
        }

    @classmethod
    def from_dict(cls: type[Part], found: Mapping[str, Any]) -> Part:
        """The result that `to_dict` gave; see `read` for what it may lack.

        Raises:
            TypeError: it lacks what this part cannot be without.
        """
        values = {n: _decoded(kind, found[key]) for key, n, kind in _fields(cls) if key in found}
        return cls(**{name: value for name, value in values.items() if value is not _UNFIT})

    @classmethod
    def read(cls: type[Part], found: "Part | Mapping[str, Any]") -> Part:
        """The same, read where it is a dictionary still.

        What does not fit its type counts as missing, and so does a part that lacks what it cannot
        be without; unknown keys are left out.

        Raises:
            TypeError: it is neither.
        """
        if isinstance(found, cls):
            return found
        if isinstance(found, Record):
            found = found.to_dict()
        if not isinstance(found, Mapping):
            kind = type(found).__name__
            raise TypeError(f"{cls.__name__} is read from a dictionary, not from {kind}.")
        return cls.from_dict(found)


def schema_of(kind: Any) -> dict[str, Any]:
    """The JSON schema of a type; "says" is what a reader is told the field must be."""
    origin, args = get_origin(kind), get_args(kind)
    if origin is Annotated:
        more = args[1]
        return {**({} if "type" in more else schema_of(args[0])), **more}
    if origin in (Union, UnionType):  # of more than one type: say it with `Annotated`
        return _or_null(schema_of(args[0]))
    if origin is Literal:
        texts = [f'"{each}"' for each in args]
        return {"enum": list(args), "says": f"{', '.join(texts[:-1])} or {texts[-1]}"}
    if origin is tuple and args[-1] is not ...:
        entry, n = schema_of(args[0]), len(args)
        return parts.entries(entry, f"{_COUNTS[n]} numbers", minItems=n, maxItems=n)
    if origin is tuple:
        says = {float: "a list of numbers", str: "a list of texts"}.get(args[0], "a list")
        return parts.entries(schema_of(args[0]), says)
    if origin is dict:
        entry = schema_of(args[1])
        return parts.each(_or_null(entry) if _is_record(args[1]) else entry)
    if not _is_record(kind):
        return _PLAIN[kind]
    needed = {
        each.name
        for each in dataclasses.fields(kind)
        if each.default is each.default_factory is dataclasses.MISSING
    }
    return parts.table(
        {
            key: schema_of(of) if name in needed else _or_null(schema_of(of))
            for key, name, of in _fields(kind)
        },
        tuple(key for key, name, _ in _fields(kind) if name in needed),
    )


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    if "enum" in schema:
        return {**schema, "enum": [*schema["enum"], None]}
    said = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if "null" in said:
        return schema
    return {**schema, "type": [*said, "null"], "says": f"{schema['says']} or null"}


@cache
def _fields(kind: type[Record]) -> tuple[tuple[str, str, Any], ...]:
    """Key in JSON, name and type of each field that is part of it; a key None says it is not."""
    types = hints_of(kind, include_extras=True)
    return tuple(
        (each.metadata.get("key", each.name), each.name, types[each.name])
        for each in dataclasses.fields(kind)  # type: ignore[arg-type]
        if each.metadata.get("key", "") is not None
    )


def _is_record(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Record)


def _encoded(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if isinstance(value, tuple):
        return [_encoded(each) for each in value]
    return {k: _encoded(each) for k, each in value.items()} if isinstance(value, dict) else value


def _decoded(kind: Any, value: Any) -> Any:
    """The value as its type has it; `_UNFIT`, or None where the type allows it, if it does not."""
    origin, args = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _decoded(args[0], value)
    if origin in (Union, UnionType):
        found = (_decoded(each, value) for each in args if each is not NoneType)
        unfit = None if NoneType in args else _UNFIT
        return next((each for each in found if each is not _UNFIT), unfit)
    if origin is tuple and isinstance(value, list | tuple):
        given = [_decoded(args[0], each) for each in value]
        if args[-1] is ...:
            return tuple(each for each in given if each is not _UNFIT)
        return tuple(given) if len(given) == len(args) and _UNFIT not in given else _UNFIT
    if origin is dict and isinstance(value, Mapping):
        entries = {str(key): _decoded(args[1], each) for key, each in value.items()}
        return {key: each for key, each in entries.items() if each is not _UNFIT}
    if origin is Literal:
        return value if value in args else _UNFIT
    if _is_record(kind) and isinstance(value, Mapping):
        try:
            return kind.from_dict(value)
        except TypeError:
            return _UNFIT
    if kind in (float, int):
        if isinstance(value, numbers.Real) and not isinstance(value, bool | int | float):
            value = int(value) if isinstance(value, numbers.Integral) else float(value)  # NumPy's
        if not _is_number(value):
            return _UNFIT
        # a whole number stays as the file has it, 2.0 too; a fraction is no count
        return _UNFIT if kind is int and value != int(value) else value
    return value if kind in (str, bool) and isinstance(value, kind) else _UNFIT


def _is_number(value: Any) -> bool:
    """True where it is a number that a later computation can work with."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST and not math.isnan(value)
