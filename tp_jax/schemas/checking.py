"""Reading JSON that somebody may have edited: a fault is one sentence that names the field."""

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax.errors import InputError

LARGEST = 1e30
"""Numbers beyond this are no result of anything; within it, squares and products stay finite."""


def read_json(path: str | Path) -> Any:
    """What a JSON file holds; NaN and infinities, which are not JSON, are refused.

    Raises:
        InputError: it cannot be read.
    """
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_refused)
    except OSError as fault:
        raise InputError(f"Cannot read {_short(str(path))}: {fault.strerror or fault}.") from fault
    except (ValueError, RecursionError) as fault:
        raise InputError(f"{path} is not JSON: {fault}.") from fault


def check(value: Any, schema: Mapping[str, Any], source: str) -> None:
    """Sees that a value is as a JSON schema wants it.

    Args:
        value: as read.
        schema: draft 2020-12. Where a part of it has "says", that is what a reader is told the
            field must be.
        source: what the sentence begins with, a file's name.

    Raises:
        InputError: names the first field that is not, and what it must be.
    """
    from jsonschema import Draft202012Validator

    try:
        _check_numbers(value, [], source)
        fault = next(Draft202012Validator(schema).iter_errors(value), None)
    except RecursionError:
        raise InputError(f"{source} is nested too deeply to be a result.") from None
    if fault is None:
        return
    place = _place(fault.absolute_path)
    if fault.validator == "required":
        missing = [name for name in fault.validator_value if name not in fault.instance]
        raise InputError(f"{source} lacks {_place([*fault.absolute_path, missing[0]])}.")
    where = f"{source}: {place}" if place else source
    raise InputError(f"{where} must be {_wanted(fault)}, but is {_said(fault.instance)}.")


def _check_numbers(value: Any, path: list, source: str) -> None:
    """Refuses a number anywhere that no later computation could work with."""
    if isinstance(value, dict | list):
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(entry, float | int | dict | list):
                _check_numbers(entry, [*path, key], source)
    elif not abs(value) <= LARGEST:
        raise InputError(
            f"{source}: {_place(path)} must be between {-LARGEST:g} and {LARGEST:g}, but is "
            f"{_said(value)}."
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
    return _short(json.dumps(value, ensure_ascii=False))


def _short(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:60]}..."


def _refused(constant: str) -> None:
    raise ValueError(f"{constant} is no number in JSON")
