"""Faults of recordings and campaigns: one sentence each, naming file, line and mend."""

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path

from tp_jax.errors import InputError


class CampaignError(InputError):
    """A recording or a campaign cannot be used as it stands.

    The message is one line: the file, the line in it where there is one, what is wrong, and how
    to mend it.

    Attributes:
        file: the file at fault, as the user named it.
        line: its 1-based line, or None where the fault has none.
    """

    def __init__(self, file: Path, wrong: str, mend: str, line: int | None = None):
        self.file = file
        self.line = line
        place = f"{file}" if line is None else f"{file}, line {line}"
        sentence = f"{place}: {wrong}; {mend}"
        # A cell, a key or a file name may itself hold a line end; the fault stays one line.
        sentence = " ".join(sentence.split())
        super().__init__(sentence if sentence.endswith("?") else f"{sentence}.")


def listed(names: Iterable[str], most: int = 8) -> str:
    """Names in quotes, with commas between them, cut off after `most`."""
    quoted = [f'"{shortened(name)}"' for name in names]
    return ", ".join(quoted[:most]) + (", ..." if len(quoted) > most else "")


def in_rows(lines: Sequence[int], most: int = 12) -> str:
    """Lists lines with a fault, to be put behind it: ", in 3 rows, lines 5, 9, 12"; one: ""."""
    if len(lines) == 1:
        return ""
    told = ", ".join(map(str, lines[:most])) + (", ..." if len(lines) > most else "")
    return f", in {len(lines)} rows, lines {told}"


def shortened(text: str, most: int = 40) -> str:
    """The text, cut off after `most` characters: a binary file has lines of any length."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like `name`, or None where none is."""
    by_lower = {each.lower(): each for each in known}
    found = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return by_lower[found[0]] if found else None


def reason(error: OSError) -> str:
    """Says why the system would not read a file, in its own words, as part of a sentence."""
    return (error.strerror or type(error).__name__).lower()
