"""starts.json, version 1: what a search with many starts has done so far, to go on from."""

from pathlib import Path
from typing import Any

from tp_jax.schemas.checking import read_versioned
from tp_jax.schemas.parts import COUNT, DIGEST, NAME, NUMBER_OR_NULL, YES_OR_NO, each, table

VERSION = "tp-jax/starts/1"

LARGEST = 1.7e308
"""Chi-squares of starts that lead nowhere are numbers of any size."""

_ARRAY = {"type": "array", "says": "a list of numbers"}

OUTCOME = table(
    {
        "x": _ARRAY,
        "information": _ARRAY,
        "states": {"type": ["array", "null"], "says": "a list of states or null"},
        **{n: NUMBER_OR_NULL for n in ("cost", "chi2_dof", "objective")},
        "evaluations": COUNT,
        "converged": YES_OR_NO,
        "message": NAME,
    },
    (
        "x",
        "information",
        "states",
        "cost",
        "chi2_dof",
        "objective",
        "evaluations",
        "converged",
        "message",
    ),
    additionalProperties=False,
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table({"sha256": DIGEST, "key": table(), "done": each(OUTCOME)}, ("sha256", "key", "done")),
}


def read_starts(path: str | Path) -> dict[str, Any]:
    """A starts.json, checked; what is in its arrays is left to those who make arrays of them.

    Raises:
        InputError: as `read_versioned`.
    """
    return read_versioned(
        path, SCHEMA, "a file of starts", "start without --resume", largest=LARGEST
    )
