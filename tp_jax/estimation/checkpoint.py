"""What a multi-start search has done so far, in a file that it can go on from."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.schemas.starts import VERSION, read_starts


class Checkpoint:
    """Results of starts by name, kept in a file that is replaced as a whole.

    The file belongs to one set of data and settings (`key`): a search with others must not go on
    from it.
    """

    def __init__(self, path: Path, key: Mapping[str, Any]):
        self.path = Path(path)
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
        stored = read_starts(self.path)
        if stored["sha256"] != self.digest:
            other = stored["key"]
            changed = [n for n in sorted({*self.key, *other}) if self.key.get(n) != other.get(n)]
            raise InputError(
                f"Cannot resume from {self.path}, which is of another search (it differs in "
                f"{', '.join(changed) or 'its contents'}); start without --resume, or with the "
                "same data and settings."
            )
        if stored["done_sha256"] != digest_of(stored["done"]):
            raise InputError(
                f"Cannot resume from {self.path}, whose starts were changed after they ended; "
                "start without --resume."
            )
        self.done = stored["done"]
        return len(self.done)

    def put(self, results: Mapping[str, Any]) -> None:
        """Adds results and writes the file: what was there stays until the new one is whole."""
        self.done.update(results)
        text = json.dumps(
            {
                "schema": VERSION, "sha256": self.digest, "key": self.key,
                "done_sha256": digest_of(self.done), "done": self.done,
            }
        )  # fmt: skip
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with replaced(self.path) as part:
            part.write_text(text, encoding="utf-8")


def digest_of(content: Mapping[str, Any]) -> str:
    """SHA-256 of what JSON can hold; the same after it was written and read."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
