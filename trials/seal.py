"""The key: written once, committed to by its hash, opened when every diagnosis is there."""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tp_jax._files import replaced
from tp_jax.errors import InputError
from tp_jax.results.diagnosis import DiagnosisRecord
from tp_jax.schemas.checking import read_versioned
from trials.schema import KEY as KEY_SCHEMA
from trials.schema import KEY_VERSION

KEY = Path("sealed", "key.json")
COMMITMENT = "KEY.sha256"


def seal(root: Path, key: Mapping[str, Any]) -> str:
    """Writes the key for its owner's eyes only, and its SHA-256 for everybody's; returns that."""
    text = json.dumps({"schema": KEY_VERSION, **key}, indent=1, allow_nan=False).encode()
    digest = hashlib.sha256(text).hexdigest()
    file = root / KEY
    file.parent.mkdir(parents=True, exist_ok=True)
    os.chmod(file.parent, 0o700)
    with replaced(file) as part:  # never there in half, whatever happens to the process
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:
            stream.write(text)
    with replaced(root / COMMITMENT) as part:
        part.write_text(f"{digest}  {KEY.as_posix()}\n", encoding="ascii")
    return digest


def sealed_with(root: Path, version: str, wanted: Mapping[str, Any]) -> str | None:
    """Digest of the key of a trial that is made by this version and as wanted; None: it is not.

    Args:
        root: the trial's folder.
        version: of the program.
        wanted: number of cases, seed and settings, as `make` takes them.
    """
    try:
        text = (root / KEY).read_bytes()
        committed = (root / COMMITMENT).read_text(encoding="ascii").split()[0]
        key = json.loads(text)
        made = {
            "cases": len(key["cases"]),
            "seed": key["seed"],
            **({"rigs": key["rigs"]} if "rigs" in key else {}),
            **key["settings"],
        }
    except (OSError, ValueError, IndexError, KeyError, TypeError):
        return None
    same = json.dumps(made) == json.dumps(wanted) and key.get("version") == version
    return committed if same and hashlib.sha256(text).hexdigest() == committed else None


def case_names(root: Path) -> list[str]:
    """Cases of a trial, in order; the key is not looked at.

    Raises:
        InputError: the folder holds no trial.
    """
    names = sorted(path.parent.name for path in root.glob("case-*/campaign.toml"))
    if not names or not (root / COMMITMENT).is_file():
        raise InputError(f"{root} holds no blind trial; make one with `./scripts/blind make`.")
    return names


def diagnosis_file(root: Path, case: str) -> Path:
    """Names the file where the diagnosis of a case belongs."""
    return root / f"{case}-diagnosis" / "diagnosis.json"


def undiagnosed(root: Path, first: int | None = None) -> list[str]:
    """Cases without a diagnosis, of all or of the first so many."""
    return [name for name in case_names(root)[:first] if not diagnosis_file(root, name).is_file()]


def open_key(root: Path, first: int | None = None) -> dict[str, Any]:
    """Opens the key to what was hidden.

    Args:
        root: the trial's folder.
        first: cases that count, in order; the others are given up, for nobody can diagnose them
            blind once the key has been opened. None: all.

    Returns:
        The key, with "cases" as far as they count, and its "sha256".

    Raises:
        InputError: a diagnosis is missing, or the key is not the one that was committed to.
    """
    names = case_names(root)
    missing = undiagnosed(root, first)
    if missing:
        raise InputError(
            f"The key stays sealed until every case has its diagnosis, but {len(missing)} of "
            f"{len(names[:first])} have none, the first {missing[0]}; write "
            f"{diagnosis_file(root, missing[0])} with `tp-jax diagnose`."
        )
    try:
        text = (root / KEY).read_bytes()
        committed = (root / COMMITMENT).read_text(encoding="ascii").split()[0]
    except (OSError, ValueError, IndexError) as fault:
        raise InputError(f"The key of {root} cannot be read: {fault}.") from fault
    if hashlib.sha256(text).hexdigest() != committed:
        raise InputError(
            f"{root / KEY} is not the key that {COMMITMENT} commits to; the trial is void, "
            "make another."
        )
    key = read_versioned(root / KEY, KEY_SCHEMA, "a key", "score it with the program that made it")
    if [entry["case"] for entry in key["cases"]] != names:
        raise InputError(f"The cases in {root} are not those of its key; put them back.")
    return {**key, "cases": key["cases"][:first], "sha256": committed}


def read_diagnosis(root: Path, entry: Mapping[str, Any]) -> dict[str, Any]:
    """The diagnosis of a case, of the very data that were given.

    Raises:
        InputError: it is no diagnosis, or one of other data.
    """
    file = diagnosis_file(root, entry["case"])
    diagnosis = DiagnosisRecord.from_json(file, fits=False).to_dict()
    if "verdict" not in diagnosis:
        raise InputError(f"{file} is no diagnosis: it has no verdict.")
    seen = (diagnosis.get("provenance") or {}).get("data_sha256")
    if seen is not None and seen != entry["sha256"]:
        raise InputError(f"{file} is a diagnosis of other data than {entry['case']} holds.")
    return diagnosis
