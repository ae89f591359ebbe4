"""The diagnoses that wait for their key are whole, and of one version of the program."""

import hashlib
import json
from pathlib import Path

import pytest

ROUND = Path(__file__).parent / "round-1"
CASES = [f"case-{i:02d}" for i in range(1, 15)]


def diagnosis(case):
    return json.loads((ROUND / f"{case}.json").read_text(encoding="utf-8"))


def test_none_is_missing():
    assert sorted(path.stem for path in ROUND.glob("*.json")) == CASES
    assert len({diagnosis(case)["provenance"]["version"] for case in CASES}) == 1


@pytest.mark.parametrize("case", CASES)
def test_each_is_whole(case):
    d = diagnosis(case)
    assert d["schema"] == "tp-jax/diagnosis/1"
    assert d["campaign"] == case
    assert d["verdict"] in ("explained", "no_gap", "unknown")
    assert bool(d["causes"]) or d["verdict"] != "explained"
    if d["verdict"] == "no_gap":
        assert not d["causes"]
        assert not d["where"]


@pytest.mark.parametrize("case", CASES)
def test_they_are_of_the_recordings_that_lie_there(shared, case):
    folder = shared / "withheld" / "round-1" / case
    if not folder.is_dir():
        pytest.skip("needs the campaigns of round 1, which are not there")
    for name, digest in diagnosis(case)["provenance"]["data_sha256"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest


def test_the_key_is_the_one_that_was_committed_to(shared):
    file = shared / "withheld" / "round-1" / "KEY.sha256"
    if not file.is_file():
        pytest.skip("needs the campaigns of round 1, which are not there")
    assert file.read_text().split()[0] in (ROUND / "README.md").read_text(encoding="utf-8")
