"""explore.json, version 1: what `tp-jax explore` keeps beside the recordings to go on from."""

from typing import Any

from tp_jax.schemas.parts import NAME, NUMBER, NUMBER_OR_NULL, TEXT, each, entries, maybe, table

VERSION = "tp-jax/explore-state/1"

_RUN = table({"omega": NUMBER_OR_NULL, "release": NUMBER_OR_NULL}, ("omega", "release"))

_FORECAST = table(
    {"run": _RUN, "largest": NUMBER_OR_NULL, "log_evidence": each(NUMBER)},
    ("run", "largest", "log_evidence"),
)

_MADE = table(
    {
        "file": NAME,
        "run": _RUN,
        "forecast": maybe(_FORECAST),
        "verdict": TEXT,
        "first": TEXT,
        "probability": NUMBER_OR_NULL,
    },
    ("file", "run", "forecast", "verdict", "first", "probability"),
)

_CAUSE = {
    "type": "array",
    "prefixItems": [NAME, NUMBER],
    "minItems": 2,
    "maxItems": 2,
    "says": "an id and a probability",
}

_FINDING = table(
    {
        "verdict": NAME,
        "causes": entries(_CAUSE, "a list of causes"),
        "first": TEXT,
        "probability": NUMBER,
        "rivals": each(NUMBER),
        "forecasts": entries(_FORECAST, "a list of forecasts"),
    },
    ("verdict", "causes", "first", "probability", "rivals", "forecasts"),
)

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table(
        {
            "runs": entries(_MADE, "a list of runs"),
            "next": maybe(_MADE),
            "finding": maybe(_FINDING),
            "diagnosed": maybe(table()),
        },
        ("runs", "next", "finding", "diagnosed"),
    ),
}
