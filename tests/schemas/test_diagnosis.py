"""diagnosis.json is checked once, when it is read, and the sentence names the field."""

import contextlib
import json
from collections import Counter

import numpy as np
import pytest

from scripts._attack.documents import mutated
from scripts._attack.small import diagnosis
from tp_jax.cli import main
from tp_jax.errors import InputError
from tp_jax.report import summary
from tp_jax.results.diagnosis import DiagnosisRecord
from tp_jax.schemas.checking import read_json


@pytest.fixture(autouse=True)
def _no_cache(monkeypatch):
    monkeypatch.setenv("TP_JAX_CACHE", "off")


@pytest.fixture
def file(tmp_path):
    return tmp_path / "diagnosis.json"


def changed(path: str, value) -> dict:
    """The small one with one entry made something else; it is taken out where that is `del`."""
    made = diagnosis()
    *above, last = [int(x) if x.isdigit() else x for x in path.split("/")]
    holder = made
    for key in above:
        holder = holder[key]
    if value is del_:
        del holder[last]
    else:
        holder[last] = value
    return made


del_ = object()


def test_a_whole_one_is_read(file):
    file.write_text(json.dumps(diagnosis()))
    assert DiagnosisRecord.from_json(file).to_dict() == diagnosis()


def test_a_diagnosis_of_the_program_is_let_through(file):
    """What `fit_record` writes, and null wherever nothing is known."""
    made = diagnosis()
    for key in set(made) - {"schema", "fits"}:
        made[key] = None
    made["fits"]["after"] = None
    file.write_text(json.dumps(made))
    DiagnosisRecord.from_json(file)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("fits", del_, "fits is missing."),
        ("fits/after", del_, "fits.after is missing."),
        ("fits/after", 3, "fits.after must be a table or null, but is 3."),
        ("fits/after/parameters/k", "0.45", "fits.after.parameters.k must be a number above"),
        ("fits/after/parameters/k", -0.45, "must be a number above zero, but is -0.45."),
        ("fits/after/parameters/k", 10**400, "but is a number of 401 digits."),
        ("fits/after/parameters/A", 1e308, "must be between -1e+30 and 1e+30, but is 1e+308."),
        ("fits/after/parameters/Ts1", del_, "fits.after.parameters.Ts1 is missing."),
        ("fits/after/nuisances/zero2", {}, "fits.after.nuisances.zero2 must be a table of one"),
        ("fits/after/nuisances/zero2", {"run-13.csv": None}, 'zero2["run-13.csv"] must be a'),
        ("fits/after/drift", {"run-13.csv": [1.0]}, 'drift["run-13.csv"] must be two numbers'),
        ("fits/after/kind", "triple", 'kind must be "single" or "double", but is "triple".'),
        ("fits/after/effects/contact_stribeck/a", True, "must be a number, or a table of one"),
        ("fits/before/eps", 0, "fits.before.eps must be a number above zero, but is 0."),
        ("causes/0/effect", ["a"], "causes[0].effect must be a text, but is a list of 1."),
        (
            "causes/0/parameters/a/value",
            "x",
            "causes[0].parameters.a.value must be a number or null",
        ),
        ("confused_with/0/1", 7, "confused_with[0][1] must be a text, but is 7."),
        ("verdict", "maybe", 'verdict must be "explained", "no_gap" or "unknown"'),
        ("recordings/0/start/before", [0.0], "start.before must be four numbers or null"),
        ("curves", [{"recording": "a", "t": [0, 10**310]}], "curves[0].t[1] must be between"),
    ],
)
def test_the_field_is_named(path, value, said, file):
    file.write_text(json.dumps(changed(path, value)))
    with pytest.raises(InputError) as fault:
        DiagnosisRecord.from_json(file)
    text = str(fault.value)
    assert text.startswith(str(file))
    assert said in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not JSON"),
        ('{"a": NaN}', "NaN is no number in JSON"),
        ('{"schema": "tp-jax/diagnosis/1", "fits": {"a": -Infinity}}', "is no number"),
        ("[" * 200_000, "is not JSON"),
        ('{"schema": ' + "9" * 5000 + "}", "is not JSON"),
        ("[]", "is not a diagnosis"),
        ('{"schema": "tp-jax/identify/1"}', "is not a diagnosis"),
        ('{"schema": "tp-jax/diagnosis/2"}', "of the version tp-jax/diagnosis/2"),
        ("\ufeff{}", "is not a diagnosis"),
    ],
)
def test_what_is_no_diagnosis(text, said, file):
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said):
        DiagnosisRecord.from_json(file)


def test_bytes_that_are_no_text(file):
    file.write_bytes(b"\xff\xfe{}")
    with pytest.raises(InputError, match="not JSON"):
        read_json(file)


def test_what_is_nested_too_deeply(file):
    text = json.dumps(changed("notes", None)).replace("null}", "[" * 700 + "]" * 700 + "}")
    file.write_text(text)
    with contextlib.suppress(InputError):  # whether it is too deep depends on the Python
        DiagnosisRecord.from_json(file)


def test_no_mutation_breaks_the_summary(file):
    seen = Counter()
    for seed in range(600):
        file.write_text(json.dumps(mutated(diagnosis(), seed)))
        try:
            made = DiagnosisRecord.from_json(file)
        except InputError:
            seen["refused"] += 1
        else:
            assert summary(made)
            seen["read"] += 1
    assert min(seen.values()) > 100


@pytest.mark.slow
def test_no_mutation_breaks_a_prediction(file, capsys):
    codes, out = Counter(), file.with_name("run.csv")
    for seed in range(300):
        under = ((), ("fits",), ("fits", "after"))[seed % 3]
        file.write_text(json.dumps(mutated(diagnosis(), seed, under)))
        run = (["--omega", "13"], ["--phi1", "1"])[seed % 2]
        argv = ["predict", str(file), *run, "--duration", "0.2", "--rate", "50", "--quiet"]
        code = main([*argv, "--out", str(out)])
        told = capsys.readouterr().err
        codes[code] += 1
        assert code in (0, 2), (seed, told)
        assert told.count("\n") == (code == 2), (seed, told)
        if code == 0:
            assert np.isfinite(np.loadtxt(out, delimiter=",", skiprows=1)).all(), seed
    assert min(codes[0], codes[2]) > 30


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("fits/after/effects", {"magic": {"a": 1.0}}, "names the effect 'magic'"),
        ("fits/after/effects", {"contact_stribeck": {"a": 1.0}}, "must give contact_stribeck"),
        ("fits/after/parameters/k", 1e29, "gives k as 1e+29 N m/rad"),
        ("fits/after/parameters/M1", -1e-3, "gives M1 as -0.001 N m"),
        ("fits/after/effects/contact_stribeck/vs", 0, "cannot be integrated"),
    ],
)
def test_what_only_the_model_knows(path, value, said, file, capsys):
    file.write_text(json.dumps(changed(path, value)))
    argv = ["predict", str(file), "--omega", "13", "--duration", "0.2", "--rate", "50"]
    assert main(argv) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert said in told.err
