"""FILE.csv.meta.json, version 1: of what is known of a recording, the part that is read back.

That is the error which the calibration leaves in its angles. What else the file says is for people.
"""

import os
from pathlib import Path
from typing import Any

from tp_jax.schemas.parts import NUMBER, NUMBER_OR_NULL, TEXT, entries, maybe, table

VERSION = "tp-jax/recording/1"


def metadata_path(recording: str | os.PathLike[str]) -> Path:
    """The place of a recording's metadata, beside it."""
    return Path(f"{os.fspath(recording)}.meta.json")


_ERROR = {
    # a reading at the fold of a bridge says nothing of the angle: null
    "angle": entries(NUMBER, "a list of rising angles"),
    "modes": entries(entries(NUMBER_OR_NULL, "a list of numbers or null"), "a list of shapes"),
}

_SENSOR = table(
    {
        "law": TEXT,
        "standard_error": maybe(
            table({"modes": {"type": ["array", "null"], "says": "a list of shapes"}})
            # without shapes there is no error to speak of, and nothing to check
            | {
                "if": {"properties": {"modes": {"minItems": 1}}, "required": ["modes"]},
                "then": {"properties": _ERROR, "required": ["angle"]},
            }
        ),
    }
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table(
        {"calibration": maybe(table({"source": TEXT, "phi1": _SENSOR, "phi2": _SENSOR}))},
    ),
}
