"""A diagnosis from end to end: verdict, every field of the contract, prediction."""

import json
import math

import numpy as np
import pytest

import tp_jax as tp
from tests import kept
from tp_jax.errors import InputError

FIELDS = {
    "schema",
    "campaign",
    "model",
    "verdict",
    "noise_floor",
    "gap",
    "where",
    "causes",
    "candidates",
    "confused_with",
    "minimum_detectable",
    "absorbed",
    "fits",
    "parameters",
    "next_experiment",
    "provenance",
}


def test_cause_is_named_and_the_gap_is_gone(short_diagnosis):
    d = short_diagnosis.to_dict()
    assert d["verdict"] == "explained"
    assert short_diagnosis.causes == ["contact_stribeck"]
    assert d["gap"]["shrink"] >= 0.9
    low, high = d["gap"]["shrink_ci95"]
    assert low <= d["gap"]["shrink"] <= high
    assert d["where"][0]["location"] == "contact"
    strength = d["causes"][0]["parameters"]["a"]
    assert strength["value"] == pytest.approx(kept.HIDDEN, abs=0.05)
    assert len(list(kept.recorded_folder().glob("*.csv"))) == 6
    assert len(d["gap"]["held_out"]) == 1
    assert d["gap"]["horizon_s"] >= 0.5
    assert ": explained by contact_stribeck, shrink " in repr(short_diagnosis)


def test_every_field_is_there(short_diagnosis):
    d = short_diagnosis.to_dict()
    assert set(d) >= FIELDS
    assert d["schema"] == "tp-jax/diagnosis/1"
    assert math.isclose(sum(w["share"] for w in d["where"]), 1.0, rel_tol=1e-9)
    assert {c["effect"] for c in d["candidates"]} == set(tp.effects.catalogue())
    shown = [c for c in d["candidates"] if c["applicable"]]
    assert [c["probability"] for c in shown] == sorted(
        (c["probability"] for c in shown), reverse=True
    )
    for c in d["candidates"]:
        if not c["applicable"]:
            assert c["note"]
            assert c["predicted_shrink"] is None
    assert set(d["parameters"]) >= {"k", "A", "B2", "c1", "M1", "Ts1"}
    for p in d["parameters"].values():
        assert set(p) >= {"value", "unit", "ci95", "identifiable"}


def test_result_is_plain_json_without_nan(short_diagnosis):
    from tp_jax.cli.output import plain

    text = json.dumps(plain(short_diagnosis.to_dict()), allow_nan=False)
    assert json.loads(text)["campaign"] == "my-rig"


def test_prediction_of_a_run_never_seen(short_campaign, short_diagnosis):
    d = short_diagnosis.to_dict()
    truth = next(r for r in short_campaign.recordings if r.omega == 17.0)
    errors = {}
    for model in ("before", "after"):
        run = tp.predict(d, omega=17.0, duration=4.0, rate=250.0, model=model)
        t, y = np.asarray(run.t), np.asarray(run.phi2)
        errors[model] = np.sqrt(np.mean((np.interp(truth.t, t, y) - truth.phi2) ** 2))
    assert errors["after"] < 2.5e-3
    assert errors["after"] < 0.5 * errors["before"]
    decay = tp.predict(d, phi1=0.5, duration=1.0, rate=250.0)
    assert float(decay.phi1[0]) == pytest.approx(0.5, abs=0.01)
    assert abs(float(decay.phi1[-1])) < 0.5


def test_prediction_says_what_is_missing(short_diagnosis):
    d = short_diagnosis.to_dict()
    with pytest.raises(InputError, match="exactly one"):
        tp.predict(d, duration=1.0, rate=10.0)
    with pytest.raises(InputError, match="duration"):
        tp.predict(d, omega=3.0)
    with pytest.raises(InputError, match="no fit"):
        tp.predict({}, omega=3.0, duration=1.0, rate=10.0)
