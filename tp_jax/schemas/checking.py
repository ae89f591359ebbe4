"""Reading JSON and TOML that somebody may have edited: a fault names the field in a sentence."""

import json
import math
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import bytes_of
from tp_jax.errors import InputError

LARGEST = 1e30
"""Numbers beyond this are no result of anything; within it, squares and products stay finite."""


class Misfit(InputError):
    """A document is not what it has to be.

    Attributes:
        said: which field, and what it must be, without the document's name.
    """

    def __init__(self, source: str, said: str):
        self.said = said
        super().__init__(f"{source}: {said}.")


def read_toml(path: str | Path) -> dict[str, Any]:
    """Reads a TOML file.

    Raises:
        InputError: it cannot be read.
    """
    try:
        return tomllib.loads(_text(path))
    except (ValueError, RecursionError) as fault:
        raise InputError(f"{path} is not TOML: {fault}.") from fault


def read_json(path: str | Path) -> Any:
    """Reads a JSON file; NaN and infinities, which are not JSON, are refused.

    Raises:
        InputError: it cannot be read.
    """
    try:
        return json_of(_text(path), str(path))
    except UnicodeDecodeError as fault:
        raise InputError(f"{path} is not JSON: {fault}.") from fault


def json_of(text: str, source: str) -> Any:
    """Reads a JSON text; `source` is what a fault's sentence begins with.

    Raises:
        InputError: it is not JSON.
    """
    try:
        return json.loads(text, parse_constant=_refused)
    except (ValueError, RecursionError) as fault:
        raise InputError(f"{source} is not JSON: {fault}.") from fault


def _text(path: str | Path) -> str:
    try:
        return bytes_of(path).decode("utf-8-sig")  # some editors begin with a mark
    except OSError as fault:
        raise InputError(f"Cannot read {_short(str(path))}: {fault.strerror or fault}.") from fault


def read_versioned(
    path: str | Path,
    schema: Mapping[str, Any],
    what: str,
    mend: str,
    *,
    largest: float = LARGEST,
) -> dict[str, Any]:
    """Reads a JSON file that says in "schema" which version it is of.

    Args:
        path: the file.
        schema: its "title" is the version that is read, say tp-jax/diagnosis/1.
        what: the file has to be, with its article.
        mend: what to do about one of another version.
        largest: size of a number.

    Raises:
        InputError: it cannot be read, is something else or of another version, or a field is not
            what it must be; the sentence names the field.
    """
    content = read_json(path)
    check_version(content, schema["title"], str(path), what, mend)
    check(content, schema, str(path), largest=largest)
    return content


def check_version(content: Any, version: str, source: str, what: str, mend: str) -> None:
    """Sees that a document is of the version that is read; see `read_versioned`."""
    said = content.get("schema") if isinstance(content, dict) else None
    if said == version:
        return
    if isinstance(said, str) and said.startswith(version.rstrip("0123456789")):
        raise InputError(
            f"{source} is of the version {said[:60]}, but this program reads {version}; {mend}."
        )
    raise InputError(f'{source} is not {what}: it lacks "schema": "{version}".')


def check(value: Any, schema: Mapping[str, Any], source: str, *, largest: float = LARGEST) -> None:
    """Sees that a value is as a JSON schema wants it.

    Args:
        value: as read.
        schema: draft 2020-12. Where a part of it has "says", that is what a reader is told the
            field must be.
        source: what the sentence begins with, a file's name.
        largest: size of a number.

    Raises:
        Misfit: names the first field that is not, and what it must be.
    """
    from jsonschema import Draft202012Validator

    try:
        _check_numbers(value, [], source, largest)
        fault = next(Draft202012Validator(schema).iter_errors(value), None)
    except RecursionError:
        raise Misfit(source, "it is nested too deeply to be a result") from None
    if fault is not None:
        raise Misfit(source, _told(fault))


def _told(fault: Any) -> str:
    """Says what is wrong, and where."""
    path = list(fault.absolute_path)
    if fault.validator == "required":
        missing = [name for name in fault.validator_value if name not in fault.instance]
        return f"{_place([*path, missing[0]])} is missing"
    if fault.validator == "additionalProperties" and fault.validator_value is False:
        known = list(fault.schema["properties"])
        unknown = next(name for name in fault.instance if name not in known)
        return f"{_place([*path, unknown])} is unknown, names are {', '.join(known)}"
    return f"{_place(path) or 'it'} must be {_wanted(fault)}, but is {_said(fault.instance)}"


def _check_numbers(value: Any, path: list, source: str, largest: float) -> None:
    """Refuses a number anywhere that no later computation could work with."""
    if isinstance(value, dict | list):
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(entry, float | int | dict | list):
                _check_numbers(entry, [*path, key], source, largest)
    elif not abs(value) <= largest:
        raise Misfit(
            source,
            f"{_place(path)} must be between {-largest:g} and {largest:g}, but is {_said(value)}",
        )


def _wanted(fault: Any) -> str:
    if isinstance(fault.schema, Mapping) and "says" in fault.schema:
        return str(fault.schema["says"])
    return f"as the schema says ({fault.validator}: {_short(str(fault.validator_value))})"


def _place(parts: Any) -> str:
    """fits.after.parameters.k, causes[0].effect"""
    text = ""
    for part in parts:
        if isinstance(part, int):
            text += f"[{part}]"
        elif re.fullmatch(r"[\w-]+", part):
            text += f".{part}" if text else part
        else:
            text += f"[{_short(json.dumps(part, ensure_ascii=False))}]"
    return text


def _said(value: Any) -> str:
    if isinstance(value, dict):
        return "a table" if value else "an empty table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > LARGEST:
        return f"a number of {int(math.log10(abs(value))) + 1} digits"
    # TOML has dates
    return _short(json.dumps(value, ensure_ascii=False, default=str))


def _short(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:60]}..."


def _refused(constant: str) -> None:
    raise ValueError(f"{constant} is no number in JSON")
