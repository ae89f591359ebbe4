"""Names of files that come from elsewhere, made safe; and what lies inside a folder."""

import re
import unicodedata
from pathlib import Path

from tp_jax.checks.proposal import may_be_data
from tp_jax.errors import InputError
from tp_jax.serve.limits import LIMITS

CAMPAIGN = "campaign.toml"


def safe_name(said: str) -> str:
    """The name of a recording as it may stand in the folder: its last part, without odd signs.

    Raises:
        InputError: nothing is left of it, it is too long, or it is no name of a data file.
    """
    last = re.split(r"[/\\]", said)[-1]
    kept = "".join(c for c in unicodedata.normalize("NFC", last) if c.isprintable())
    name = re.sub(r'[<>:"|?*]', "-", kept).strip(". ")
    if not name:
        raise InputError(f"{said[:40]!r} is no name of a file; give it another.")
    if len(name.encode()) > LIMITS.name:
        raise InputError(
            f"The name {name[:40]}... has {len(name.encode())} bytes, but may have {LIMITS.name}; "
            "shorten it."
        )
    if name != CAMPAIGN and not name.endswith(".meta.json") and not may_be_data(name):
        raise InputError(
            f"{name} holds no recording by the end of its name; drop data files, as CSV or text."
        )
    return name


def inside(folder: Path, path: Path) -> bool:
    """True if a path lies in a folder once all links are followed."""
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # a link to itself; a folder that is not ours to look into
        return False


def readable(folder: Path, path: Path) -> bool:
    """True if a path is a file in a folder, once all links are followed."""
    try:
        return inside(folder, path) and path.is_file()
    except OSError:
        return False
