"""Single diagnoses against the truth, by hand."""

import pytest

from tests.trials.conftest import diagnosis_of, part_of_key
from trials import truth
from trials.judge import among_first, judge, said, tied

SPRING, TILT, WEAR, CROSS, TURNS = (
    "spring_asymmetry",
    "column_tilt",
    "contact_wear",
    "sensor_crosstalk",
    "drive_frequency",
)


def one(id=SPRING, size=0.02):
    return part_of_key("case-001", "one", {id: size})


def test_right():
    row = judge(one(), diagnosis_of("explained", [SPRING], least={SPRING: 0.004}))
    right = ("top1", "top1_alone", "top3", "location", "channel")
    assert [row[name] for name in right] == [True] * 5
    assert row["multiple"] == pytest.approx(5.0)
    assert row["multiples"][SPRING]["scale"] == "diagnosis"
    assert row["false_alarm"] is row["unknown"] is row["both_named"] is None


def test_second_is_not_first():
    row = judge(one(), diagnosis_of("explained", [WEAR, SPRING]))
    assert not row["top1"]
    assert row["top3"]
    assert not row["location"]
    assert row["undetectable"]  # no size of it, says the diagnosis
    assert row["multiples"][SPRING] == {"value": None, "scale": "diagnosis"}
    assert row["multiple"] is None


def test_outside_the_catalogue_the_rig_has_the_scale():
    row = judge(part_of_key("case-001", "outside", {"motor_stall": 0.1}), diagnosis_of("unknown"))
    assert row["multiples"]["motor_stall"] == {"value": 4.0, "scale": "reference"}
    assert row["undetectable"] is row["explained"] is None


def test_a_tie_counts_as_one():
    found = diagnosis_of("explained", [TILT], candidates=[TILT, SPRING], tied=[[TILT, SPRING]])
    row = judge(one(), found)
    assert row["top1"]
    assert not row["top1_alone"]
    assert row["location"]


def test_a_tie_of_four_does_not():
    tie = [[TILT, SPRING, WEAR, CROSS]]
    found = diagnosis_of("explained", [TILT], candidates=[TILT, SPRING], tied=tie)
    assert tied(found, SPRING) == {SPRING}
    row = judge(one(), found)
    assert not row["top1"]
    assert not row["location"]


def test_without_causes_candidates_rank():
    ranked = [TILT, WEAR, SPRING, CROSS]
    row = judge(one(), diagnosis_of("unknown", candidates=ranked))
    assert row["top1"] is False
    assert row["top3"]
    assert not judge(one(CROSS), diagnosis_of("unknown", candidates=ranked))["top3"]


def test_a_tie_takes_one_place():
    ranked = [TILT, WEAR, TURNS, SPRING]
    assert not among_first(diagnosis_of("unknown", candidates=ranked), SPRING, 3)
    assert among_first(diagnosis_of("unknown", candidates=ranked, tied=[[TILT, WEAR]]), SPRING, 3)


def test_causes_come_before_candidates():
    found = diagnosis_of("unknown", [CROSS], candidates=[TILT, WEAR, SPRING])
    assert among_first(found, WEAR, 3)
    assert not among_first(found, SPRING, 3)


def test_not_applicable_is_no_candidate():
    found = diagnosis_of("unknown")
    found["candidates"] = [{"effect": SPRING, "applicable": False}]
    assert not among_first(found, SPRING, 3)


@pytest.mark.parametrize(
    ("verdict", "causes", "alarm"),
    [("no_gap", [], False), ("unknown", [], True), ("explained", [WEAR], True)],
)
def test_false_alarm(verdict, causes, alarm):
    row = judge(part_of_key("case-001", "none", {}), diagnosis_of(verdict, causes))
    assert row["false_alarm"] is alarm
    assert row["top1"] is None


def test_outside():
    entry = part_of_key("case-001", "outside", {"motor_stall": 0.3})
    row = judge(entry, diagnosis_of("unknown", [TURNS]))
    assert row["unknown"]
    assert row["channel"]
    assert said(row) == "unknown"
    row = judge(entry, diagnosis_of("explained", [WEAR]))
    assert not row["unknown"]
    assert not row["channel"]
    assert said(row) == WEAR


def test_two():
    entry = part_of_key("case-001", "two", {SPRING: 0.02, WEAR: 0.1})
    assert judge(entry, diagnosis_of("explained", [WEAR, SPRING]))["both_named"]
    row = judge(entry, diagnosis_of("unknown", [WEAR]))
    assert not row["both_named"]
    assert row["one_named"]
    # one cause does not stand for two, even where all are tied
    assert not judge(entry, diagnosis_of("x", [WEAR], tied=[[WEAR, SPRING]]))["both_named"]
    least = {SPRING: 0.01, WEAR: 0.01}
    assert judge(entry, diagnosis_of("x", [], least=least))["multiple"] == pytest.approx(2.0)


def test_size_of_what_differs_from_run_to_run():
    entry = one(TURNS, 0.2)
    entry["given"]["runs"] = [
        {"file": "a", "release": 0.5, "values": {TURNS: [9.0]}},  # the motor stands
        {"file": "b", "omega": 8.0, "values": {TURNS: [0.3]}},
        {"file": "c", "omega": 9.0, "values": {TURNS: [-0.4]}},
        {"file": "d", "omega": 9.5, "values": {TURNS: [7.0]}},
    ]
    found = diagnosis_of("explained", [TURNS], least={TURNS: 0.1})
    found["gap"]["held_out"] = ["d"]
    assert truth.multiple(entry, TURNS, found)[0] == pytest.approx(5.0)


def test_coverage_of_intervals():
    found = diagnosis_of("explained", [SPRING])
    found["causes"][0]["parameters"] = {"a": {"value": 0.021, "ci95": [0.019, 0.022]}}
    found["parameters"] = {
        "k": {"value": 0.46, "ci95": [0.455, 0.465], "identifiable": True},
        "T0": {"value": 4.0, "ci95": [0.0, 9.0]},
        "B1": {"value": 1.2e-3, "ci95": None},
    }
    assert judge(one(), found)["coverage"] == {"amplitudes": [True], "parameters": [False]}
    # of a wrong model nothing is asked
    assert judge(one(WEAR), found)["coverage"] == {"amplitudes": [], "parameters": []}


SETTLES = "contact_wear_exponential"


def cousin_of_wear() -> dict:
    return part_of_key("case-001", "cousin", {SETTLES: 0.3})


def test_a_cousin_is_named_by_its_kind():
    row = judge(cousin_of_wear(), diagnosis_of("explained", [WEAR]))
    assert row["cousin"]
    assert row["cousin_location"]
    assert row["channel"]
    assert row["top1"] is row["unknown"] is row["explained"] is None
    assert row["multiples"][SETTLES] == {"value": 4.0, "scale": "reference"}
    assert said(row) == WEAR
    row = judge(cousin_of_wear(), diagnosis_of("explained", [SPRING, WEAR]))
    assert row["cousin"] is row["cousin_location"] is False
    assert judge(cousin_of_wear(), diagnosis_of("no_gap"))["cousin"] is False


def test_or_by_one_tied_with_it():
    tie = diagnosis_of("explained", [CROSS], candidates=[CROSS, WEAR], tied=[[CROSS, WEAR]])
    row = judge(cousin_of_wear(), tie)
    assert row["cousin"]
    assert row["cousin_location"]


@pytest.mark.parametrize(
    ("family", "right"),
    [("contact_dry.t", True), ("contact.t", True), ("contact_dry.v2", False), ("spring.t", False)],
)
def test_or_by_a_law_of_its_family(family, right):
    for named in ({"effect": family}, {"effect": "law", "family": family}):
        found = diagnosis_of("explained")
        found["causes"] = [{"kind": "learned", "probability": 0.9, **named}]
        row = judge(cousin_of_wear(), found)
        assert row["cousin"] is right
        assert row["first"] == {"probability": 0.9, "right": right}


def test_first_cause_as_stated():
    def stated(entry, causes, **more):
        found = diagnosis_of("explained", causes, **more)
        for cause in found["causes"]:
            cause["probability"] = 0.97
        first = judge(entry, found)["first"]
        return first and first["right"]

    assert stated(one(), [SPRING])
    assert stated(one(), [TILT], tied=[[SPRING, TILT]])
    assert stated(one(), [TILT, SPRING]) is False
    assert stated(part_of_key("c", "none", {}), [TILT]) is False
    assert stated(part_of_key("c", "outside", {"motor_stall": 0.1}), [TURNS]) is False
    assert stated(part_of_key("c", "two", {SPRING: 0.02, WEAR: 0.1}), [WEAR])
    assert stated(one(), []) is None
    # no probability, no answer
    assert judge(one(), diagnosis_of("explained", [SPRING]))["first"] is None


def test_without_B1_torques_are_counted_per_unit_of_it():
    entry = part_of_key("c", "one", {TILT: 2.4e-3})
    entry["given"]["effects"][TILT]["unit"] = ["N m"]
    entry["unit_torque"] = 1.2e-3
    assert truth.sizes(entry, TILT) == {"a": pytest.approx(2.0)}
    assert truth.parameters(entry) == {"k": pytest.approx(375.0), "B1": pytest.approx(1.0)}
    found = diagnosis_of("explained", [TILT], least={TILT: 0.5})
    assert judge(entry, found)["multiple"] == pytest.approx(4.0)
    found["causes"][0]["parameters"] = {"a": {"value": 2.1, "ci95": [1.9, 2.2]}}
    assert judge(entry, found)["coverage"]["amplitudes"] == [True]
