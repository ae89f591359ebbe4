"""The diagnoses that wait for their key are whole, and each round is of one version."""

import hashlib
import json
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROUNDS = {"round-1": 14, "round-2": 20}
CASES = [(name, f"case-{i:02d}") for name, many in ROUNDS.items() for i in range(1, many + 1)]


def diagnosis(name, case):
    return json.loads((HERE / name / f"{case}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ROUNDS)
def test_none_is_missing(name):
    cases = [case for of, case in CASES if of == name]
    assert sorted(path.stem for path in (HERE / name).glob("*.json")) == cases
    assert len({diagnosis(name, case)["provenance"]["version"] for case in cases}) == 1


@pytest.mark.parametrize(("name", "case"), CASES)
def test_each_is_whole(name, case):
    d = diagnosis(name, case)
    assert d["schema"] == "tp-jax/diagnosis/1"
    assert d["campaign"] == case
    assert d["verdict"] in ("explained", "no_gap", "unknown")
    assert bool(d["causes"]) or d["verdict"] != "explained"
    if d["verdict"] == "no_gap":
        assert not d["causes"]
        assert not d["where"]


@pytest.mark.parametrize(("name", "case"), CASES)
def test_they_are_of_the_recordings_that_lie_there(shared, name, case):
    folder = shared / "withheld" / name / case
    if not folder.is_dir():
        pytest.skip(f"needs the campaigns of {name}, which are not there")
    for file, digest in diagnosis(name, case)["provenance"]["data_sha256"].items():
        assert hashlib.sha256((folder / file).read_bytes()).hexdigest() == digest


@pytest.mark.parametrize("name", ROUNDS)
def test_the_key_is_the_one_that_was_committed_to(shared, name):
    file = shared / "withheld" / name / "KEY.sha256"
    if not file.is_file():
        pytest.skip(f"needs the campaigns of {name}, which are not there")
    assert file.read_text().split()[0] in (HERE / name / "README.md").read_text(encoding="utf-8")
