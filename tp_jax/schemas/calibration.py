"""Calibrations of the angle sensors as TOML files; `recordings.calibration` shows one."""

from collections.abc import Mapping
from typing import Any

from tp_jax.schemas.parts import NUMBER, entries, table


def _square(size: int) -> dict[str, Any]:
    row = entries(NUMBER, f"{size} numbers", minItems=size, maxItems=size)
    return entries(row, f"{size} rows of {size}", minItems=size, maxItems=size)


def _of_law(law: str, names: tuple[str, ...]) -> dict[str, Any]:
    """Returns what a sensor needs, if it is one of this law."""
    wanted = table(
        {
            "law": {"const": law},
            **{name: NUMBER for name in names},
            "covariance": _square(len(names)),
            "errors": table({name: NUMBER for name in names}, additionalProperties=False),
            "span": entries(NUMBER, "two numbers", minItems=2, maxItems=2),
            "residual": NUMBER,
        },
        names,
        additionalProperties=False,
    )
    return {"if": {"properties": {"law": {"const": law}}}, "then": wanted}


def schema(laws: Mapping[str, tuple[str, ...]]) -> dict[str, Any]:
    """Of a calibration.

    Args:
        laws: law -> names of its parameters, in the order of its covariance.
    """
    law = {"enum": list(laws), "says": f"one of {', '.join(laws)}"}
    sensor = table({"law": law}, ("law",), allOf=[_of_law(*each) for each in laws.items()])
    return table({"phi1": sensor, "phi2": sensor}, ("phi1",), additionalProperties=False)
