"""Findings of a check, and how they are reported."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

Level = Literal["wrong", "doubtful", "mended"]

LEVELS: tuple[Level, ...] = get_args(Level)
"""Levels in the order in which they are reported."""


@dataclass(frozen=True)
class Finding:
    """Something about recordings that cannot be right, or that may well be wrong.

    Attributes:
        kind: what was looked at: "file", "units", "frequency", "rider", "clipped", "sampling",
            "motion", "held", "clock", "read".
        level: "wrong" is refused, "doubtful" is reported, "mended" was mended when the file was
            read.
        recordings: labels of those it is about.
        wrong: what it is, as part of a sentence.
        mend: what to write or do.
        numbers: what was measured, by name.
    """

    kind: str
    level: Level
    recordings: tuple[str, ...]
    wrong: str
    mend: str
    numbers: Mapping[str, float] = field(default_factory=dict)

    @property
    def sentence(self) -> str:
        """Recording, what is wrong, and the mend, in one sentence."""
        names = ", ".join(self.recordings[:6]) + (", ..." if len(self.recordings) > 6 else "")
        begin = f"{names}: " if names else ""
        end = f"; {self.mend}" if self.mend else ""
        return f"{begin}{self.wrong}{end}."
