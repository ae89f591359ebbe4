"""Results are the same as types and as JSON, to the order of their keys."""

import copy
import dataclasses
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

from scripts._attack.documents import mutated
from scripts._attack.small import diagnosis
from tests.report.conftest import KINDS
from tp_jax.cli.output import json_text
from tp_jax.errors import InputError
from tp_jax.gap.diagnosis import Diagnosis
from tp_jax.report import summary
from tp_jax.results import diagnosis as types
from tp_jax.results.diagnosis import VERSION, Cause, DiagnosisRecord, Gap
from tp_jax.results.encoding import Record, schema_of

TESTS = Path(__file__).parent.parent
STORED = [*sorted((TESTS / "golden").glob("*.json")), *sorted(TESTS.glob("withheld/*/*.json"))]


@pytest.mark.parametrize("file", STORED, ids=lambda file: file.stem)
def test_a_stored_diagnosis_stays_word_for_word(file):
    found = json.loads(file.read_text(encoding="utf-8"))
    assert json_text(DiagnosisRecord.from_json(file).to_dict()) == json_text(found)
    assert json_text(Diagnosis.from_json(file.read_text("utf-8")).to_dict()) == json_text(found)


def test_there_are_stored_ones():
    assert len(STORED) > 15


@pytest.mark.parametrize("kind", ["explained", "unknown", "partly", "bare", "empty"])
def test_a_made_up_diagnosis_stays_as_it_is_where_it_fits(kind):
    made = {**KINDS[kind]()}
    made.pop("fits", None)  # not whole
    assert DiagnosisRecord.read(made).to_dict() == made


def test_a_field_that_is_not_given_is_no_key():
    assert Cause("a").to_dict() == {"effect": "a"}
    assert Cause("a", shrink=None).to_dict() == {"effect": "a", "shrink": None}
    assert Gap(shrink=0.5, held_out=("a.csv",)).to_dict() == {"shrink": 0.5, "held_out": ["a.csv"]}


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_a_copy_has_the_same_keys(copied):
    found = DiagnosisRecord.read(diagnosis())
    assert copied(found) == found
    assert copied(found).to_dict() == found.to_dict()


@pytest.mark.parametrize(
    ("given", "left"),
    [
        ({"gap": {"shrink": float("nan")}}, {"gap": {"shrink": None}}),
        ({"gap": {"shrink": "much"}, "notes": "a"}, {"gap": {"shrink": None}}),
        ({"gap": {"shrink_ci95": [0.1]}}, {"gap": {"shrink_ci95": None}}),
        ({"where": [{"share": 1.0}, {"location": "base"}]}, {"where": [{"location": "base"}]}),
        ({"verdict": "perhaps", "else": 1}, {"verdict": None}),
        ({"parameters": {"k": None, "A": {"value": 1}}}, {"parameters": {"A": {"value": 1}}}),
        ({"confused_with": None, "campaign": None}, {"confused_with": None}),
    ],
)
def test_what_does_not_fit_counts_as_missing(given, left):
    assert DiagnosisRecord.read(given).to_dict() == left


def test_no_mutation_breaks_what_is_read_without_a_check():
    for seed in range(300):
        assert summary(mutated(diagnosis(), seed))


def test_several_sizes_of_one_cause_can_be_read_back():
    """An amplitude that every recording has its own of was refused."""
    made = diagnosis()
    made["causes"][0]["parameters"]["a"] = {"value": [0.4, 0.6], "unit": "1", "ci95": None}
    (cause,) = DiagnosisRecord.from_json(json.dumps(made)).accepted
    assert cause.parameters["a"].value == (0.4, 0.6)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "The diagnosis is not JSON"),
        ('{"schema": "tp-jax/diagnosis/1"}', "The diagnosis: fits is missing."),
        (json.dumps(diagnosis() | {"notes": [1]}), "The diagnosis: notes[0] must be a text"),
        (json.dumps(diagnosis() | {"curves": [{"t": 1}]}), "curves[0].t must be a list of numbers"),
        (json.dumps(diagnosis() | {"noise": {"phi1": 1}}), "noise.phi1 must be a table or null"),
    ],
)
def test_a_text_is_checked_as_a_file_is(text, said):
    with pytest.raises(InputError) as fault:
        Diagnosis.from_json(text)
    assert said in str(fault.value)


def test_every_type_has_a_schema_and_no_field_may_be_anything():
    kinds = [k for k in vars(types).values() if isinstance(k, type) and issubclass(k, Record)]
    assert len(kinds) > 25
    for kind in set(kinds) - {Record}:
        assert schema_of(kind)["type"] == "object"
        for name, field in schema_of(kind)["properties"].items():
            assert {"type", "enum"} & set(field), (kind, name)


def test_a_diagnosis_does_what_can_be_done_with_it(tmp_path):
    found = Diagnosis.read(diagnosis())
    assert (found.verdict, found.causes) == ("explained", ["contact_stribeck"])
    assert repr(found) == "Diagnosis('bench': explained by contact_stribeck, shrink 0.98)"
    assert found.summary() == summary(diagnosis())
    found.write_report(tmp_path / "report.html")
    assert "contact_stribeck" in (tmp_path / "report.html").read_text("utf-8")
    shown = dataclasses.replace(found, campaign="<b>")._repr_html_()
    assert "The gap is explained" in shown
    assert "&lt;b&gt;" in shown
    assert "<b><b>" not in shown
    assert shown.count("<tr>") == 3
    assert "<table>" not in Diagnosis.read({})._repr_html_()
    run = found.predict(omega=13.0, duration=0.2, rate=50.0)
    assert run.phi1.shape == (11,)


def test_a_dictionary_is_read_and_not_taken_for_a_field():
    with pytest.raises(TypeError):
        DiagnosisRecord({"schema": VERSION})


def test_a_fraction_is_no_count():
    assert DiagnosisRecord.read({"provenance": {"seed": 3}}).provenance.seed == 3
    assert DiagnosisRecord.read({"provenance": {"seed": 3.5}}).provenance.seed is None


@pytest.mark.unchecked
def test_a_path_is_not_read():
    with pytest.raises(TypeError, match="read from a dictionary, not from str"):
        DiagnosisRecord.read("diagnosis.json")


def test_defaults_are_nobody_elses():
    one, other = DiagnosisRecord(), DiagnosisRecord()
    one.provenance.data_sha256["run.csv"] = "0"
    assert other.provenance.data_sha256 == {}


def test_text_may_begin_with_a_mark_and_a_path_with_a_brace(tmp_path):
    text = json.dumps({"schema": VERSION, "campaign": "rig"})
    assert DiagnosisRecord.from_json("\ufeff" + text, fits=False).campaign == "rig"
    file = tmp_path / "{rig}.json"
    file.write_text(text, encoding="utf-8")
    assert DiagnosisRecord.from_json(file, fits=False).campaign == "rig"


def test_numbers_of_numpy_count():
    found = DiagnosisRecord.read({"gap": {"shrink": np.float32(0.5)}})
    assert found.gap.shrink == 0.5
