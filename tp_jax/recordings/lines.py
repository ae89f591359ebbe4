"""A data file as text: its encoding, its line ends, and the numbers of its lines."""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from tp_jax._files import bytes_of
from tp_jax.recordings.faults import CampaignError, nearest, reason

_SEPARATORS = ",;|\"' \t\v\f\xa0\x1a"
"""Characters that an empty row of a table is written with, and the end of a file in DOS."""


@dataclass(frozen=True)
class Lines:
    """The lines of a file that are not blank.

    Attributes:
        file: the file they come from.
        text: the lines, without their ends.
        numbers: 1-based line of each in the file, blank ones counted.
        sha256: of the file's bytes, in hexadecimal.
    """

    file: Path
    text: list[str]
    numbers: list[int]
    sha256: str


def read_bytes(file: Path) -> bytes:
    """The bytes of a file.

    Raises:
        CampaignError: the file is missing or cannot be read.
    """
    if not os.path.exists(file):  # False also for what could be no name at all
        near = nearest(file.name, [each.name for each in _siblings(file)])
        mend = f'did you mean "{near}"?' if near else "correct the name or put the file there"
        raise CampaignError(file, "there is no such file", mend)
    try:
        return bytes_of(file)
    except OSError as error:
        raise CampaignError(
            file, f"the file cannot be read ({reason(error)})", "name a data file that can be read"
        ) from error


def as_lines(file: Path, raw: bytes) -> Lines:
    """The lines of a text with any line ends (also CR CR LF), with or without a byte-order mark.

    Raises:
        CampaignError: it holds nothing but blank lines.
    """
    physical = _split(_decoded(raw))
    kept = [(line, i) for i, line in enumerate(physical, start=1) if line and not line.isspace()]
    if not kept:
        raise CampaignError(file, "the file is empty", "record it again or remove its entry")
    return Lines(
        file=file,
        text=[line for line, _ in kept],
        numbers=[i for _, i in kept],
        sha256=hashlib.sha256(raw).hexdigest(),
    )


def without_separators(lines: Lines, keep: int = 0) -> tuple[Lines, list[int]]:
    """The lines that hold more than delimiters, as `;;;`, and the numbers of those left out.

    Args:
        lines: of a file.
        keep: how many lines at the top stay as they are.
    """
    bare = [i >= keep and not line.strip(_SEPARATORS) for i, line in enumerate(lines.text)]
    if not any(bare) or all(bare):
        return lines, []
    kept = [i for i, out in enumerate(bare) if not out]
    left_out = [lines.numbers[i] for i, out in enumerate(bare) if out]
    text, numbers = [lines.text[i] for i in kept], [lines.numbers[i] for i in kept]
    return Lines(lines.file, text, numbers, lines.sha256), left_out


def read_lines(file: Path) -> Lines:
    """The lines of a text file.

    Raises:
        CampaignError: the file is missing, cannot be read, or holds nothing but blank lines.
    """
    return as_lines(file, read_bytes(file))


def _siblings(file: Path) -> list[Path]:
    try:
        return sorted(file.parent.iterdir())
    except OSError:
        return []


def _decoded(raw: bytes) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Only a unit in the header ("°") can be at stake; Latin-1 decodes any byte.
        return raw.decode("latin-1")


def _split(text: str) -> list[str]:
    # A run of CRs before an LF is one line end: some makers' programs write CR CR LF.
    # str.splitlines would also split at form feeds and the like, and the numbers would be off.
    while "\r\n" in text:
        text = text.replace("\r\n", "\n")
    return text.replace("\r", "\n").split("\n")
