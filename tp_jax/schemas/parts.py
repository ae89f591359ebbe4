"""Parts that schemas are made of. "says" is what a reader is told the field must be."""

from typing import Any

NUMBER = {"type": "number", "says": "a number"}
NUMBER_OR_NULL = {"type": ["number", "null"], "says": "a number or null"}
ABOVE_ZERO = {
    "type": "number",
    "exclusiveMinimum": 0,
    "says": "a number above zero",
}
TEXT = {"type": ["string", "null"], "says": "a text or null"}
NAME = {"type": "string", "says": "a text"}
COUNT = {"type": "integer", "minimum": 0, "says": "a whole number, zero or more"}
DIGEST = {"type": "string", "pattern": "^[0-9a-f]{64}$", "says": "a SHA-256 in hexadecimal digits"}
YES_OR_NO = {"type": "boolean", "says": "true or false"}
FLAG = {"type": ["boolean", "null"], "says": "true, false or null"}


def table(
    fields: dict[str, Any] | None = None, required: tuple[str, ...] = (), **more: Any
) -> dict[str, Any]:
    """A table that must be there; what is not among its fields may be anything."""
    schema = {"type": "object", "properties": fields or {}, "required": list(required)}
    return {**schema, "says": "a table", **more}


def maybe(schema: dict[str, Any]) -> dict[str, Any]:
    """The same, or null."""
    return {**schema, "type": [schema["type"], "null"], "says": f"{schema['says']} or null"}


def each(entry: dict[str, Any], says: str = "a table", **more: Any) -> dict[str, Any]:
    """A table of any keys whose entries are all alike."""
    return {"type": "object", "additionalProperties": entry, "says": says, **more}


def entries(entry: dict[str, Any], says: str, **more: Any) -> dict[str, Any]:
    """A list that must be there, of entries that are alike."""
    return {"type": "array", "items": entry, "says": says, **more}
