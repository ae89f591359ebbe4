"""Results of a long computation so far, in a file that it can go on from."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.schemas import fits, starts


@dataclass(frozen=True)
class Contents:
    """Kind of results that a checkpoint holds.

    Attributes:
        version: in the file's "schema". read: of a path, the file's content, checked.
        work: what goes on from it. pieces: what it holds.
    """

    version: str
    read: Callable[[Path], dict[str, Any]]
    work: str
    pieces: str


STARTS = Contents(starts.VERSION, starts.read_starts, "search", "starts")
FITS = Contents(fits.VERSION, fits.read_fits, "diagnosis", "fits")


class Checkpoint:
    """Results by name, kept in a file that is replaced as a whole.

    The file belongs to one set of data and settings (`key`): work with others must not go on
    from it.
    """

    def __init__(self, path: Path, key: Mapping[str, Any], contents: Contents = STARTS):
        self.path, self.contents = Path(path), contents
        self.key = json.loads(json.dumps(key))
        self.done: dict[str, Any] = {}

    @property
    def digest(self) -> str:
        """SHA-256 of the key."""
        return digest_of(self.key)

    def resume(self) -> int:
        """Reads what is there; how many results that is.

        Raises:
            InputError: the file is missing, cannot be read, or is of other data or settings.
        """
        if not self.path.is_file():
            raise InputError(f"There is nothing to resume at {self.path}; start without --resume.")
        stored = self.contents.read(self.path)
        if stored["sha256"] != self.digest:
            other = stored["key"]
            changed = [n for n in sorted({*self.key, *other}) if self.key.get(n) != other.get(n)]
            raise InputError(
                f"Cannot resume from {self.path}, which is of another {self.contents.work} (it "
                f"differs in {', '.join(changed) or 'its contents'}); start without --resume, or "
                "with the same data and settings."
            )
        if stored.get("done_sha256") != digest_of(stored["done"]):
            raise InputError(
                f"Cannot resume from {self.path}, whose {self.contents.pieces} were changed after "
                "they ended; start without --resume."
            )
        self.done = stored["done"]
        return len(self.done)

    def put(self, results: Mapping[str, Any]) -> None:
        """Adds results and writes the file: what was there stays until the new one is whole."""
        self.done.update(results)
        text = json.dumps(
            {
                "schema": self.contents.version,
                "sha256": self.digest,
                "key": self.key,
                "done_sha256": digest_of(self.done),
                "done": self.done,
            }
        )
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with replaced(self.path) as part:
            part.write_text(text, encoding="utf-8")


def digest_of(content: Mapping[str, Any]) -> str:
    """SHA-256 of what JSON can hold; the same after it was written and read."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
