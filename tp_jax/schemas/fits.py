"""fits.json, version 1: the fits that a diagnosis has done so far, to go on from."""

from pathlib import Path
from typing import Any

from tp_jax.schemas.checking import read_versioned
from tp_jax.schemas.parts import COUNT, DIGEST, NAME, YES_OR_NO, each, table

VERSION = "tp-jax/fits/1"

_NAMES = {"type": "array", "says": "a list of texts"}

FIT = table(
    {
        **{name: NAME for name in ("x", "states", "cost", "message")},
        "evaluations": COUNT,
        "converged": YES_OR_NO,
        "programs": {"type": "array", "items": _NAMES, "says": "a list of lists of texts"},
        "ends_at": DIGEST,
    },
    ("x", "states", "cost", "message", "evaluations", "converged", "programs", "ends_at"),
    additionalProperties=False,
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table({"sha256": DIGEST, "key": table(), "done": each(FIT)}, ("sha256", "key", "done")),
}


def read_fits(path: str | Path) -> dict[str, Any]:
    """A fits.json, checked; its numbers are texts, which hold every bit of them.

    Raises:
        InputError: as `read_versioned`.
    """
    return read_versioned(path, SCHEMA, "a file of fits", "start without --resume")
