"""Files that appear or change at once and whole, and what goes into them as JSON."""

import errno
import json
import math
import os
import stat
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

LARGEST = 2_000_000_000
"""Bytes of a file that is read as a whole: ten million rows of a recording take 0.6 GB."""


def bytes_of(file: str | os.PathLike[str]) -> bytes:
    """Reads a file, if it has an end: a device may go on for ever, a pipe may never begin.

    Raises:
        OSError: it is no regular file, is too large, or the file system refuses.
    """
    about = os.stat(file)
    if not stat.S_ISREG(about.st_mode) and not stat.S_ISDIR(about.st_mode):  # which says so itself
        raise OSError(errno.EINVAL, "It is a device or a pipe", os.fspath(file))
    if about.st_size > LARGEST:
        raise OSError(errno.EFBIG, f"It has more than {LARGEST / 1e9:g}e9 bytes", os.fspath(file))
    with open(file, "rb") as stream:
        return stream.read()


@contextmanager
def replaced(target: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to; what was written takes the target's place when the block ends well.

    A link goes on pointing where it did, and a file that is replaced keeps its permissions. A
    target that is no regular file (/dev/null, a pipe) is written to directly.

    Raises:
        OSError: the file system refuses; what was there stays as it was.
    """
    path = Path(os.path.realpath(target))
    if path.exists() and not path.is_file():
        yield path  # a folder says so itself
        return
    # In the same folder, since a file can be renamed at once only within one file system. The
    # suffix tells libraries the format; a name of its own, since several may write at once.
    part = path.with_name(f".{path.stem}.{uuid.uuid4().hex}{path.suffix}")
    try:
        yield part
        with part.open("rb") as stream:  # on the disk before it has the name
            os.fsync(stream.fileno())
        if path.exists():
            part.chmod(stat.S_IMODE(path.stat().st_mode))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)  # gone already where all went well


@contextmanager
def created(target: str | os.PathLike[str]) -> Iterator[Path]:
    """A path to write to, as `replaced` gives it; what was written becomes a file of a new name.

    Raises:
        FileExistsError: something has the name, which stays as it was.
        OSError: the file system refuses.
    """
    path = Path(target)
    part = path.with_name(f".{path.stem[:40]}.{uuid.uuid4().hex}{path.suffix}")
    try:
        yield part
        with part.open("rb") as stream:
            os.fsync(stream.fileno())
        path.open("xb").close()  # takes the name, or says that it is taken
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_json(target: str | os.PathLike[str], content: Any) -> Any:
    """Writes or replaces a file of JSON; returns the content in JSON's own types.

    Raises:
        OSError: the file system refuses; what was there stays as it was.
    """
    own = plain(content)
    text = json.dumps(own, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with replaced(target) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return own


def plain(value: Any) -> Any:
    """The value in JSON's own types: arrays become lists, NaN and infinities null."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, set | frozenset):
        return sorted(plain(entry) for entry in value)
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):  # NumPy's and JAX's scalars and arrays, without importing either
        return plain(value.tolist())
    raise TypeError(f"{type(value).__name__} has no form in JSON.")
