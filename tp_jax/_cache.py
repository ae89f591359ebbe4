"""A folder of programs kept between runs: whose it is, how large it may be, what is spoiled in it.

A program that is read from there runs with the user's rights, so nobody else may write there. It
is found by a name made of all that it depends on, so that what is old is never wrong, only in the
way; the limit takes what was not used for longest.
"""

import os
import stat
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

COMPILED = "-cache"
"""Ends the names of JAX's files."""

ZSTD = b"\x28\xb5\x2f\xfd"
"""Begins what zstandard packed; where it is not installed, JAX takes zlib."""

STAMP = "checked"
"""Empty; as old as the last look into files that JAX wrote."""


@dataclass(frozen=True)
class Policy:
    """Limits of what a cache may take.

    Attributes:
        most_bytes: of all files together. A version of the package leaves some 60 MB for each
            kind of campaign; this is room for a few dozen.
        kept_bytes: left after a cleaning, so that not every run has to clean.
        settled_s: age in seconds from which on nobody is writing a file any more.
    """

    most_bytes: int = 2_000_000_000
    kept_bytes: int = 1_600_000_000
    settled_s: float = 60.0


def made(folder: Path) -> None:
    """Makes a folder, and those above it, for the user alone.

    Raises:
        OSError: it cannot be made.
    """
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)


def distrusted(*folders: Path) -> str | None:
    """Says why programs from these folders cannot be run, and what to do; None: they can."""
    if not hasattr(os, "getuid"):  # Windows has other ways
        return None
    for folder in folders:
        about = folder.stat()
        if about.st_uid != os.getuid():
            return f"{folder} belongs to somebody else; remove it, or set XDG_CACHE_HOME"
        if about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            return f"others may write to {folder}; remove it, or chmod go-w"
    return None


def clean(root: Path, policy: Policy | None = None) -> None:
    """Takes away what is spoiled, and what was not used for longest where there is too much.

    Args:
        root: the folder, with those in it.
        policy: what it may take.
    """
    policy = policy or Policy()
    begun = time.time()
    files = list(_files(root))
    stamp = root / STAMP
    seen = stamp.stat().st_mtime if stamp.is_file() else 0.0
    for path, about in files:
        settled = about.st_mtime < begun - policy.settled_s
        if settled and path.name.startswith("."):  # the writer was killed
            _take(path)
        elif settled and about.st_mtime >= seen and path.name.endswith(COMPILED):
            _take(path, unless=whole)
    with suppress(OSError):
        stamp.touch()
        os.utime(stamp, (begun - policy.settled_s, begun - policy.settled_s))
    total = sum(about.st_size for _, about in files)
    if total <= policy.most_bytes:
        return
    # some file systems note no use: there the oldest goes
    for path, about in sorted(files, key=lambda f: max(f[1].st_atime, f[1].st_mtime)):
        if total <= policy.kept_bytes:
            break
        _take(path)
        total -= about.st_size


def whole(path: Path) -> bool:
    """True where one of JAX's files can be unpacked; JAX puts nothing in place of one that can't.

    True of what nothing here can unpack.
    """
    content = path.read_bytes()
    unpack = _zstd() if content.startswith(ZSTD) else zlib.decompress
    try:
        return unpack is None or bool(unpack(content))
    except Exception:  # each library has faults of its own
        return False


def _zstd() -> Callable[[bytes], bytes] | None:
    """Finds zstandard's decompression as JAX finds it."""
    try:
        from compression import zstd  # Python 3.14  # pyright: ignore[reportMissingImports]
    except ImportError:
        pass
    else:
        return zstd.decompress
    try:
        import zstandard
    except ImportError:
        return None
    return zstandard.ZstdDecompressor().decompress


def _files(root: Path) -> Iterator[tuple[Path, os.stat_result]]:
    for folder, _, names in os.walk(root):
        for name in names:
            path = Path(folder, name)
            with suppress(OSError):  # another process cleans too
                about = path.lstat()
                if stat.S_ISREG(about.st_mode) and path != root / STAMP:
                    yield path, about


def _take(path: Path, unless: Callable[[Path], bool] | None = None) -> None:
    with suppress(OSError):
        if unless is None or not unless(path):
            path.unlink()
