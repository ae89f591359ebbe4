"""Numbers with their errors, as all results have them."""

from dataclasses import dataclass
from typing import Annotated

from tp_jax.results.encoding import Record, Schema
from tp_jax.schemas import parts

Interval = tuple[float | None, float | None]
"""Ends of a 95 % interval; None where it is open."""


@dataclass(frozen=True)
class Size(Record):
    """A number that was fitted, with its unit; several where every recording has its own."""

    value: Annotated[
        float | tuple[float, ...] | None,
        Schema(
            type=["number", "array", "null"],
            items=parts.NUMBER,
            says="a number or null, or a list of one for each recording",
        ),
    ] = None
    unit: str = ""
    ci95: Interval | None = None
    identifiable: bool | None = None
    standard_error: float | None = None


@dataclass(frozen=True)
class Correlation(Record):
    """Correlations of the errors of parameters: names (q,), matrix (q, q)."""

    names: tuple[str, ...] = ()
    matrix: tuple[tuple[float | None, ...], ...] = ()
