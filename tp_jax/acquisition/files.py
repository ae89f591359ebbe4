"""Files that appear or change at once and whole."""

import os
import stat
from pathlib import Path


def replace_file(target: Path, content: bytes) -> None:
    """Puts a content in a file's place: a reader sees the old or the new one, never a part.

    A link goes on pointing where it did, and the file keeps its permissions.

    Raises:
        OSError: the file system refuses.
    """
    path = Path(os.path.realpath(target))
    # in the same folder, since a file can be renamed at once only within one file system
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        if path.exists():
            part.chmod(stat.S_IMODE(path.stat().st_mode))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)  # gone already where all went well
