"""Time at which a recording was made, as `tp-jax record` writes it in FILE.csv.meta.json."""

from datetime import datetime
from pathlib import Path

from tp_jax.errors import InputError
from tp_jax.schemas.checking import read_json
from tp_jax.schemas.recording import VERSION, metadata_path


def read_started(recording: Path) -> str | None:
    """The moment at which a run began, in ISO 8601; None where nothing usable says it.

    A date is for people and decides nothing: one that cannot be read is no fault.
    """
    file = metadata_path(recording)
    if not file.is_file():
        return None
    try:
        content = read_json(file)
    except InputError:
        return None
    if not isinstance(content, dict) or content.get("schema") != VERSION:
        return None
    try:
        return datetime.fromisoformat(content["started"]).isoformat()
    except (KeyError, TypeError, ValueError):
        return None
