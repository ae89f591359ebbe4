"""Names that the figures share."""

CHANNELS = {"phi1": "φ1", "phi2": "φ2"}


def short(label: str) -> str:
    """A recording's name without what all share."""
    return label.removesuffix(".csv")
