"""Contents of a sealed trial: its key, the part of the key that is one case's, and measures.

The key cannot be edited without breaking its seal; a case's part is read back where a trial that
was interrupted goes on, and a measure where a diagnosis was measured before.
"""

from typing import Any

from tp_jax.schemas.parts import FLAG, NAME, NUMBER, NUMBER_OR_NULL, each, entries, maybe, table

KEY_VERSION = "tp-jax/blind-key/1"

_EFFECT = table(
    {"location": NAME, "channel": NAME, "sizes": each(NUMBER), "shapes": each(NUMBER)},
    ("location", "channel", "sizes", "shapes", "in_catalogue"),
)

CASE = table(
    {
        "case": NAME,
        "kind": {
            "enum": ["one", "two", "none", "outside", "cousin"],
            "says": '"one", "two", "none", "outside" or "cousin"',
        },
        "reference": table(),
        "sha256": each(NAME),
        "given": table(
            {
                "effects": each(_EFFECT),
                "parameters": each(NUMBER_OR_NULL),
                "runs": entries(table({"file": NAME}, ("file",)), "a list of runs"),
            },
            ("effects", "parameters", "runs"),
        ),
    },
    ("case", "kind", "reference", "sha256", "given"),
)

KEY: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": KEY_VERSION,
    **table({"cases": entries(CASE, "a list of cases")}, ("cases",)),
}

_KEPT = {"diagnosis_sha256": NAME}

#: sealed.json
SHRINK = table(
    {**_KEPT, "shrink": NUMBER_OR_NULL, "best": NUMBER_OR_NULL},
    (*_KEPT, "shrink", "best"),
)

#: harm.json
HARM = table(
    {**_KEPT, "windowed": FLAG, "free_run": FLAG, "rms": maybe(table())},
    (*_KEPT, "windowed", "free_run"),
)
