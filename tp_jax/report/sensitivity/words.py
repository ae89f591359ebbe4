"""Names that the figures share."""

from collections.abc import Mapping
from typing import Any

CHANNELS = {"phi1": "φ1", "phi2": "φ2"}


def channels(table: Mapping[str, Any]) -> list[str]:
    """The measured channels of an entry."""
    return [c for c in CHANNELS if c in table]


def short(label: str) -> str:
    """A recording's name without what all share."""
    return label.removesuffix(".csv")
