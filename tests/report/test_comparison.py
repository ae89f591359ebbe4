"""Two diagnoses side by side."""

import copy

import pytest

from tests.report.conftest import fit_with
from tp_jax.report.comparison import compared, rows, text
from tp_jax.results.diagnosis import DiagnosisRecord

TORQUES = ("N m", "kg m^2")


def per_inertia(content):
    """The same rig, whose campaign gives no B1: all torques are in units of it."""
    content = copy.deepcopy(content)
    B1 = content["fits"]["before"]["parameters"]["B1"]
    content["fits"]["before"]["parameters"]["B1"] = 1.0
    for size in content["parameters"].values():
        if str(size["unit"]).startswith(TORQUES):
            size["value"] /= B1
            size["ci95"] = None if size["ci95"] is None else [x / B1 for x in size["ci95"]]
    return content


def test_a_rig_without_its_inertia_is_no_other_rig(made):
    content = made("explained")
    content["fits"] = {"before": fit_with(1.2e-3), "after": None}
    a, b = map(DiagnosisRecord.read, (content, per_inertia(content)))
    found = compared(a, b)
    assert found["B1"] == [1.2e-3, None]
    assert not any(each["differs"] for each in found["parameters"].values())
    said = text(a, b)
    assert "not given, torques are per B1" in said
    for row in rows(a, b):
        if "/B1" in row[1]:
            assert row[1] == row[2]
    assert any("/B1" in row[1] for row in rows(a, b))


def test_numbers_that_differ_are_printed_differently(made):
    content, other = made("explained"), made("explained")
    content["parameters"]["k"] |= {"value": 0.44610, "ci95": [0.44607, 0.44613]}
    other["parameters"]["k"] |= {"value": 0.44632, "ci95": [0.44629, 0.44635]}
    row = next(r for r in rows(*map(DiagnosisRecord.read, (content, other))) if r[0] == "k *")
    assert row[1].startswith("0.446100 N m/rad (0.446070")
    assert row[2].startswith("0.446320 N m/rad (0.446290")


def test_sizes_of_each_recording_are_a_range(made):
    content = made("explained")
    cause = content["causes"][0]
    cause["parameters"] = {
        "a": {"value": [0.05, -0.02, 0.11], "unit": "rad/s", "ci95": None, "identifiable": True}
    }
    found = DiagnosisRecord.read(content)
    row = next(r for r in rows(found, found) if r[0].startswith("cause"))
    assert "a −0.0200 to 0.110 rad/s over 3 recordings" in row[1]


@pytest.mark.parametrize("verdict", ["explained", None])
def test_a_verdict_that_is_missing_is_not_unknown(made, verdict):
    content = made("explained")
    content["verdict"] = verdict
    found = DiagnosisRecord.read(content)
    row = next(r for r in rows(found, found) if r[0] == "verdict")
    assert row[1] == (verdict or "–")
