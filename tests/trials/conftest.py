"""Trials whose truth and whose diagnoses are written by hand."""

import json
from pathlib import Path

import pytest

from trials.seal import diagnosis_file, seal

LOCATIONS = {
    "spring_asymmetry": ("spring", "column"),
    "column_tilt": ("column", "column"),
    "contact_wear": ("contact", "contact"),
    "sensor_crosstalk": ("sensor2", "sensor2"),
    "drive_frequency": ("drive", "column"),
    "motor_stall": ("drive", "column"),
    "contact_wear_exponential": ("contact", "contact"),
}
COUSINS = {"contact_wear_exponential": {"of": "contact_wear", "family": "contact_dry.t"}}


def part_of_key(case: str, kind: str, sizes: dict[str, float]) -> dict:
    """A case as the key has it: its effects with one amplitude each."""
    return {
        "case": case,
        "kind": kind,
        "reference": {id: {"multiple": 4.0, "factor": 0.1} for id in sizes},
        "cousins": {id: COUSINS[id] for id in sizes if id in COUSINS},
        "sha256": {"run-01.csv": "ab"},
        "given": {
            "effects": {
                id: {
                    "sizes": {"a": size},
                    "shapes": {},
                    "unit": ["1"],
                    "location": LOCATIONS[id][0],
                    "channel": LOCATIONS[id][1],
                    "in_catalogue": id != "motor_stall" and id not in COUSINS,
                }
                for id, size in sizes.items()
            },
            "parameters": {"k": 0.45, "B1": 1.2e-3},
            "runs": [{"file": "run-01.csv", "release": 0.5, "values": {}}],
        },
    }


def diagnosis_of(
    verdict: str, causes=(), *, candidates=(), tied=(), least=None, shrink=None, where=None, **more
) -> dict:
    """A diagnosis.json with what a score looks at."""
    place = where or (causes[0] if causes else None)
    location, channel = LOCATIONS.get(place, (None, None))
    return {
        "schema": "tp-jax/diagnosis/1",
        "verdict": verdict,
        "causes": [{"effect": id, "parameters": {}} for id in causes],
        "candidates": [{"effect": id, "location": LOCATIONS[id][0]} for id in candidates],
        "confused_with": [list(group) for group in tied],
        "where": [{"location": location, "channel": channel, "share": 1.0}] if place else [],
        "minimum_detectable": {id: {"value": x, "unit": "1"} for id, x in (least or {}).items()},
        "gap": {"shrink": shrink, "held_out": []},
        "parameters": {},
        "provenance": {"data_sha256": {"run-01.csv": "ab"}},
        **more,
    }


@pytest.fixture
def trial(tmp_path):
    """Writes a trial: cases as (kind, sizes of what is hidden, diagnosis or None)."""

    def write(*cases) -> Path:
        entries = []
        for i, (kind, sizes, diagnosis) in enumerate(cases):
            name = f"case-{i + 1:03d}"
            (tmp_path / name).mkdir()
            (tmp_path / name / "campaign.toml").write_text("")
            entries.append(part_of_key(name, kind, sizes))
            if diagnosis is not None:
                put(tmp_path, name, diagnosis)
        seal(tmp_path, {"seed": 5, "cases": entries})
        return tmp_path

    return write


def put(root: Path, case: str, diagnosis: dict) -> None:
    """A diagnosis in its place."""
    file = diagnosis_file(root, case)
    file.parent.mkdir()
    file.write_text(json.dumps(diagnosis))
