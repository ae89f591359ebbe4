"""Measures of whole trials, whose numbers are known by hand."""

import json

import pytest
from scipy import stats

from scripts._blind.__main__ import main
from tests.trials.conftest import diagnosis_of
from tp_jax.errors import InputError
from trials import pool, score
from trials.measures import mean, reliability, share
from trials.table import sheets

SPRING, TILT, WEAR = "spring_asymmetry", "column_tilt", "contact_wear"

FOUND, MIXED_UP, MISSED, BOTH = (
    diagnosis_of("explained", [SPRING], least={SPRING: 0.005}, shrink=0.95),
    diagnosis_of(
        "explained",
        [TILT],
        candidates=[TILT, SPRING],
        tied=[[SPRING, TILT]],
        least={SPRING: 0.005},
        shrink=0.85,
    ),
    diagnosis_of("no_gap", candidates=[SPRING, TILT, WEAR], least={WEAR: 0.08}),
    diagnosis_of("explained", [SPRING, WEAR], shrink=1.0, least={SPRING: 0.005, WEAR: 0.08}),
)

CASES = (
    ("one", {SPRING: 0.02}, FOUND),
    ("one", {SPRING: 0.02}, MIXED_UP),
    ("one", {WEAR: 0.1}, MISSED),
    ("none", {}, diagnosis_of("no_gap")),
    ("none", {}, diagnosis_of("unknown", where=TILT)),
    ("outside", {"motor_stall": 0.3}, diagnosis_of("unknown", [TILT])),
    ("two", {SPRING: 0.02, WEAR: 0.1}, BOTH),
)


def test_all_measures(trial):
    scored = score(trial(*CASES))
    assert scored["schema"] == "tp-jax/blind/1"
    assert scored["cases"] == 7
    assert scored["kinds"] == {"one": 3, "none": 2, "outside": 1, "two": 1}
    value = {
        name: (m["value"], m["n"])
        for name, m in scored.items()
        if isinstance(m, dict) and "value" in m
    }
    assert value["top1"] == (pytest.approx(2 / 3), 3)
    assert value["top1_alone"] == (pytest.approx(1 / 3), 3)
    assert value["top3"] == (1.0, 3)
    assert value["location"] == (pytest.approx(2 / 3), 3)
    assert value["false_alarm"] == (0.5, 2)
    assert value["unknown"] == (1.0, 1)
    assert value["channel_outside"] == (1.0, 1)
    assert value["both_named"] == (1.0, 1)
    # the undetected one has no shrink, and is not counted
    assert value["shrink_error"] == (pytest.approx((0.05 + 0.15 + 0.0) / 3), 3)
    assert value["shrink_near"] == (pytest.approx(2 / 3), 3)
    assert scored["shrink_error"]["on"] == "the run it held out"


def test_by_size(trial):
    scored = score(trial(*CASES))
    assert scored["from_3"]["top1"] | {"ci95": None} == {"value": 1.0, "n": 2, "ci95": None}
    bands = {band["from"]: band for band in scored["bands"]}
    assert bands[1.0]["top1"]["value"] == 0.0
    assert bands[3.0]["top1"]["n"] == 2
    assert bands[3.0]["unknown"]["n"] == 1
    # the smaller of two
    assert bands[1.0]["both_named"]["n"] == 1
    assert bands[10.0]["to"] is None
    assert sum(band["top1"]["n"] for band in bands.values()) == 3


def test_confusion(trial):
    scored = score(trial(*CASES))
    assert scored["confusion"] == {
        "contact_wear": {"no_gap": 1},
        "contact_wear + spring_asymmetry": {"contact_wear + spring_asymmetry": 1},
        "motor_stall": {"unknown": 1},
        "none": {"no_gap": 1, "unknown": 1},
        "spring_asymmetry": {SPRING: 1, TILT: 1},
    }
    assert scored["effects"][WEAR]["instead"] == {"no_gap": 1}
    assert scored["effects"][SPRING]["top1"]["n"] == 2


def test_shrinks_on_sealed_runs(trial):
    asked = []

    def shrinks(root, entry, diagnosis):
        asked.append(entry["case"])
        return {"shrink": -3.0, "best": 0.8}  # far worse than the baseline: nothing is taken

    scored = score(trial(*CASES), shrinks=shrinks)
    assert asked == ["case-001", "case-002", "case-003", "case-007"]
    assert scored["shrink_error"]["value"] == pytest.approx(0.8)
    assert scored["shrink_error"]["on"] == "sealed runs"


def test_nothing_to_ask(trial):
    scored = score(trial(("none", {}, diagnosis_of("no_gap"))))
    assert scored["top1"] == {"value": None, "n": 0, "ci95": None}
    assert json.dumps(scored, allow_nan=False)


def test_wilson():
    # Newcombe (1998), Statistics in Medicine 17, table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29
    for yes, n, low, high in [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ]:
        of = share([True] * yes + [False] * (n - yes))
        assert of["value"] == yes / n
        assert of["ci95"] == pytest.approx([low, high], abs=5e-5)


def test_interval_of_a_mean():
    x = stats.norm.rvs(size=200, random_state=1)
    low, high = mean(x)["ci95"]
    assert (low, high) == pytest.approx(
        [x.mean() + z * stats.sem(x) for z in (-1.96, 1.96)], abs=0.02
    )
    assert mean([0.5]) == {"value": 0.5, "n": 1, "ci95": None}
    assert mean([0.5, 0.5])["ci95"] == [0.5, 0.5]


def test_command(trial, capsys):
    root = trial(*CASES)
    assert main(["score", str(root), "--quick", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["top1"]["n"] == 3
    assert main(["score", str(root), "--quick"]) == 0
    told = capsys.readouterr().out
    assert "7 cases" in told
    assert "motor_stall" in told
    (root / "KEY.sha256").unlink()
    assert main(["score", str(root)]) == 2
    assert "no blind trial" in capsys.readouterr().err


def test_trials_are_pooled_case_by_case(trial):
    root = trial(*CASES)
    one = score(root)
    other = json.loads(json.dumps(one | {"keys": ["of another trial"]}))
    both = pool([one, other])
    assert both["cases"] == 2 * one["cases"]
    assert both["keys"] == [*one["keys"], "of another trial"]
    assert both["top1"]["n"] == 2 * one["top1"]["n"]
    assert both["top1"]["value"] == pytest.approx(one["top1"]["value"])
    assert both["top1"]["ci95"][0] > one["top1"]["ci95"][0]
    assert both["shrink_error"]["on"] == "the run it held out"
    with pytest.raises(InputError, match="there twice"):
        pool([one, one])
    with pytest.raises(InputError, match="must be scores"):
        pool([one, {"schema": "tp-jax/diagnosis/1"}])
    sealed = other | {"shrink_error": {**other["shrink_error"], "on": "sealed runs"}}
    with pytest.raises(InputError, match="cannot be pooled"):
        pool([one, sealed])


def test_cousins(trial):
    settles = "contact_wear_exponential"
    scored = score(
        trial(
            ("cousin", {settles: 0.3}, diagnosis_of("explained", [WEAR])),
            ("cousin", {settles: 0.3}, diagnosis_of("unknown", [TILT])),
        )
    )
    assert scored["cousin"] | {"ci95": 0} == {"value": 0.5, "n": 2, "ci95": 0}
    assert scored["cousin_location"]["value"] == 0.5
    assert scored["top1"]["n"] == scored["unknown"]["n"] == 0
    assert scored["effects"][settles]["instead"] == {TILT: 1}
    heads = [row[0] for row in sheets(scored)[0].rows]
    assert "cousin, its kind named first" in heads


def test_harm_is_asked_of_diagnoses_with_causes(trial):
    answers = iter([(True, False), (False, False), (None, True), (None, None), (False, False)])

    def harms(root, entry, diagnosis):
        assert diagnosis["causes"]
        return dict(zip(("windowed", "free_run"), next(answers), strict=True))

    scored = score(trial(*CASES), harms=harms)
    value = {
        n: (scored[n]["value"], scored[n]["n"]) for n in ("harm", "harm_windowed", "harm_free_run")
    }
    assert value == {"harm": (2 / 3, 3), "harm_windowed": (0.5, 2), "harm_free_run": (1 / 3, 3)}
    assert next(answers) == (False, False)  # four have causes


def test_reliability():
    rows = reliability([(0.3, False), (0.5, True), (0.95, True), (0.99, True), (1.0, False)])
    assert [row["n"] for row in rows] == [1, 1, 0, 1, 2]
    assert [(row["from"], row["to"]) for row in rows][-1] == (0.99, 1.0)
    assert rows[-1]["right"] == 0.5
    assert rows[-1]["stated"] == pytest.approx(0.995)
    assert rows[2] == {"from": 0.8, "to": 0.9, "n": 0, "stated": None, "right": None, "ci95": None}


def test_reliability_is_in_the_score(trial):
    found = diagnosis_of("explained", [SPRING])
    found["causes"][0]["probability"] = 0.97
    scored = score(trial(("one", {SPRING: 0.02}, found)))
    assert [row["n"] for row in scored["reliability"]] == [0, 0, 0, 1, 0]
    assert sheets(scored)[-1].rows == [("0.9–0.99", "0.970", "1.00 (0.21–1.00), n 1")]
    # scores that were kept before have none
    old = json.loads(json.dumps(scored))
    for row in old["rows"]:
        for name in ("first", "cousin", "cousin_location"):
            row.pop(name)
    assert len(sheets(pool([old]))) == 3


def test_clean_and_rough_rigs_are_not_pooled(trial):
    one = score(trial(*CASES))
    assert one["rigs"] == "clean"
    with pytest.raises(InputError, match="clean and on rough"):
        pool([one, one | {"keys": ["of another trial"], "rigs": "rough"}])
