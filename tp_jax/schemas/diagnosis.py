"""diagnosis.json, version 1: what a prediction or a report made from it rests on.

What is not named here may be there and be anything. A report leaves out what is missing or null,
so most of it may be; `fits`, from which predictions are made, has to be whole.
"""

from pathlib import Path
from typing import Any

from tp_jax.schemas.checking import read_versioned
from tp_jax.schemas.parts import (
    ABOVE_ZERO,
    FLAG,
    INTERVAL,
    NAME,
    NUMBER,
    NUMBER_OR_NULL,
    SIZES,
    TEXT,
    each,
    listed,
    maybe,
    table,
)

VERSION = "tp-jax/diagnosis/1"

_COLUMN = ("B1", "k", "A", "c1", "M1")
_RIDER = ("B2", "Tv", "Ts1", "Tst", "T0")

#: One value, or one for each recording.
AMPLITUDE = {
    "type": ["number", "object"], "additionalProperties": NUMBER, "minProperties": 1,
    "says": "a number, or a table of one for each recording",
}  # fmt: skip

FIT = table(
    {
        "kind": {"enum": ["single", "double"], "says": '"single" or "double"'},
        "parameters": table(
            {
                **{n: NUMBER for n in (*_COLUMN, *_RIDER, "Ts2")},
                **{n: ABOVE_ZERO for n in ("B1", "B2", "k", "T0")},
            },
            _COLUMN,
        ),
        "reaction": NUMBER,
        "eps": ABOVE_ZERO,
        "nuisances": table(
            {
                **{n: NUMBER for n in ("phase", "gain", "level", "zero1")},
                "zero2": each(NUMBER, "a table of one number for each recording", minProperties=1),
            },
            ("phase", "gain", "level", "zero1", "zero2"),
        ),
        "drift": maybe(
            each({**INTERVAL, "type": "array", "items": NUMBER, "says": "two numbers"}),
        ),
        "effects": each(each(AMPLITUDE)),
    },
    ("kind", "parameters", "reaction", "eps", "nuisances", "effects"),
    # a rider has numbers of its own
    **{
        "if": {"properties": {"kind": {"const": "double"}}, "required": ["kind"]},
        "then": {"properties": {"parameters": {"required": [*_RIDER, "Ts2"]}}},
    },
)

_NUMBERS = {"type": "array", "items": NUMBER, "says": "a list of numbers"}
_ERRORS = maybe(table({"windowed": NUMBER_OR_NULL, "free_run": NUMBER_OR_NULL}))
_STATE = {
    "type": ["array", "null"], "items": NUMBER, "minItems": 4, "maxItems": 4,
    "says": "four numbers or null",
}  # fmt: skip

#: Of a learned cause; see `tp_jax.gap.law_curve`.
_CURVE = maybe(
    table(
        {
            "argument": TEXT,
            "unit": TEXT,
            "y_unit": TEXT,
            "x": _NUMBERS,
            "y": _NUMBERS,
            "ci95": {
                "type": "array", "items": {**INTERVAL, "type": "array", "items": NUMBER},
                "says": "a list of pairs of numbers",
            },
            "visited": maybe(table({"edges": _NUMBERS, "share": _NUMBERS})),
        },
        ("x", "y"),
    )
)  # fmt: skip

SCHEMA: dict[str, Any] = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": VERSION,
    **table(
        {
            "campaign": TEXT,
            "model": TEXT,
            "verdict": {
                "enum": ["explained", "no_gap", "unknown", None],
                "says": '"explained", "no_gap" or "unknown"',
            },
            "noise_floor": maybe(each(NUMBER_OR_NULL)),
            "gap": maybe(
                table(
                    {
                        "before": _ERRORS,
                        "after": _ERRORS,
                        "shrink": NUMBER_OR_NULL,
                        "shrink_ci95": INTERVAL,
                        "shrink_by_recording": each(NUMBER_OR_NULL),
                        "held_out": listed(NAME),
                        "horizon_s": NUMBER_OR_NULL,
                        "removable_significant": FLAG,
                        "structure_p": NUMBER_OR_NULL,
                        "structure_p_after": NUMBER_OR_NULL,
                    }
                )
            ),
            "where": listed(
                table(
                    {"location": NAME, "channel": TEXT, "share": NUMBER_OR_NULL, "when": TEXT},
                    ("location",),
                )
            ),
            "causes": listed(
                table(
                    {
                        "effect": NAME,
                        "kind": TEXT,
                        "location": TEXT,
                        "channel": TEXT,
                        "probability": NUMBER_OR_NULL,
                        "shrink": NUMBER_OR_NULL,
                        "parameters": SIZES,
                        "formula": TEXT,
                        "curve": _CURVE,
                    },
                    ("effect",),
                )
            ),
            "candidates": listed(
                table(
                    {
                        "effect": NAME,
                        "location": TEXT,
                        "channel": TEXT,
                        "applicable": FLAG,
                        "predicted_shrink": NUMBER_OR_NULL,
                        "realised_shrink": NUMBER_OR_NULL,
                        "probability": NUMBER_OR_NULL,
                        "note": TEXT,
                    },
                    ("effect",),
                )
            ),
            "confused_with": listed(
                {"type": "array", "items": NAME, "says": "a list of effects"}, "a list of groups"
            ),
            "minimum_detectable": SIZES,
            "absorbed": maybe(
                each(
                    maybe(
                        table(
                            {
                                "shift": NUMBER_OR_NULL,
                                "in_standard_errors": NUMBER_OR_NULL,
                                "unit": TEXT,
                            }
                        )
                    )
                )
            ),
            "fits": table({"before": FIT, "after": maybe(FIT)}, ("before", "after")),
            "parameters": SIZES,
            "next_experiment": maybe(
                table(
                    {
                        "omega": NUMBER_OR_NULL,
                        "forced": FLAG,
                        "separates": listed(NAME),
                        "expected_sigma": NUMBER_OR_NULL,
                    }
                )
            ),
            "recordings": listed(
                table(
                    {
                        "label": NAME,
                        "file": TEXT,
                        "sha256": TEXT,
                        "held_out": FLAG,
                        "forced": FLAG,
                        "omega": NUMBER_OR_NULL,
                        "start": maybe(table({"before": _STATE, "after": _STATE})),
                    },
                    ("label",),
                )
            ),
            "curves": listed(table({"recording": TEXT})),
            "residuals": listed(table({"recording": TEXT})),
            "notes": listed(NAME, "a list of texts"),
            "provenance": maybe(table({"version": TEXT, "seed": NUMBER_OR_NULL})),
        },
        ("fits",),
    ),
}


WITHOUT_FITS = {**SCHEMA, "required": []}
"""A diagnosis that is only looked at."""


def read_diagnosis(path: str | Path, *, fits: bool = True) -> dict[str, Any]:
    """A diagnosis.json, checked.

    Args:
        path: the file.
        fits: whether they have to be there; nothing is predicted without.

    Raises:
        InputError: it cannot be read, is of another version, or a field is not what it must be;
            the sentence names the field.
    """
    schema = SCHEMA if fits else WITHOUT_FITS
    return read_versioned(path, schema, "a diagnosis", "diagnose the campaign again")
