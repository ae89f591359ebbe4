"""Measures kept beside the diagnosis they are of, which take minutes to make."""

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.schemas.checking import check, read_json

OF = "diagnosis_sha256"


def kept(
    file: Path, diagnosis: Path, schema: Mapping[str, Any], measure: Callable[[], dict[str, Any]]
) -> dict[str, Any]:
    """Reads the file where it is of this very diagnosis, or else returns what `measure` finds.

    Args:
        file: JSON; made anew where it is missing, spoiled or of another diagnosis.
        diagnosis: its file.
        schema: that the file has to have.
        measure: makes what is kept.
    """
    digest = hashlib.sha256(diagnosis.read_bytes()).hexdigest()
    if file.is_file():
        try:
            known = read_json(file)
            check(known, schema, str(file))
        except InputError:  # nothing is lost: it is measured again
            known = {}
        if known.pop(OF, None) == digest:
            return known
    found = measure()
    with replaced(file) as part:
        part.write_text(json.dumps({OF: digest, **found}) + "\n", encoding="utf-8")
    return found
