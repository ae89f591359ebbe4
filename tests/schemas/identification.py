"""What `tp-jax identify --json` writes, version 1."""

from typing import Any

from tp_jax.schemas.parts import (
    COUNT,
    FLAG,
    INTERVAL,
    NAME,
    NUMBER,
    NUMBER_OR_NULL,
    TEXT,
    YES_OR_NO,
    each,
    entries,
    maybe,
    table,
)

VERSION = "tp-jax/identify/1"

_PARAMETER = table(
    {"value": NUMBER, "unit": NAME, "ci95": INTERVAL, "identifiable": FLAG}, ("value", "unit")
)

_START = table(
    {"objective": NUMBER_OR_NULL, "converged": YES_OR_NO, "evaluations": COUNT, "message": NAME},
    ("objective", "converged", "evaluations", "message"),
)

_WARNING = table(
    {"code": NAME, "parameters": entries(NAME, "a list of parameters"), "text": NAME},
    ("code", "text"),
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table(
        {
            "campaign": TEXT,
            "model": NAME,
            "method": NAME,
            "parameters": each(_PARAMETER),
            "objective": NUMBER_OR_NULL,
            "chi2_dof": NUMBER_OR_NULL,
            "noise_floor": each(NUMBER_OR_NULL),
            "starts": entries(_START, "a list of starts"),
            "success": table({"reached": COUNT, "of": COUNT, "ci95": INTERVAL}, ("reached", "of")),
            "warnings": entries(_WARNING, "a list of warnings"),
            "provenance": maybe(table({"version": TEXT, "seed": NUMBER_OR_NULL})),
        },
        ("model", "method", "parameters", "objective", "starts", "success", "warnings"),
    ),
}
