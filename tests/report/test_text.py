"""The verdict as text: short, plain, with the cause and the numbers."""

import pytest

from tp_jax.report import summary
from tp_jax.report.verdict import sentences


def test_short_and_plain(diagnosis):
    lines = summary(diagnosis).splitlines()
    assert 1 <= len(lines) <= 25
    assert max(map(len, lines)) <= 125
    text = "\n".join(lines)
    for word in ("None", "nan", "\x1b"):
        assert word not in text


def test_says_the_cause_and_the_numbers(made):
    text = summary(made("explained"))
    for part in (
        "case-03",
        "contact_stribeck",
        "97 %",
        "98 % of the removable gap is gone",
        "96 % to 99 %",
        "52.0 mrad",
        "1.40 mrad",
        "1.00 mrad",
        "0.580",
        "0.550 to 0.610",
        "predicted shrink",
        "contact_asymmetry",
        "−40 %",
        "This data cannot tell contact_stribeck from contact_presliding.",
        "8 rad/s",
        "6.1 standard",
    ):
        assert part in " ".join(text.split()) or part in text


def test_no_gap_is_said_without_overclaiming(made):
    text = summary(made("no_gap"))
    assert "No gap was found" in text
    assert "p = 0.41" in text
    assert "may be there all the same" in text
    assert "is gone" not in text


def test_unknown_is_said_honestly(made):
    said = sentences(made("unknown"))
    assert said.heading == "There is a gap that is not explained"
    assert "contact between column and rider: 71 %" in said.where
    assert "outside the catalogue" in said.what
    assert said.how_far == "Nothing was added to the model, so the gap stays as it is."


def test_partly_explained_is_not_called_explained(made):
    said = sentences(made("partly"))
    assert said.heading == "The gap is explained only in part"
    assert "contact_stribeck" in said.what
    assert "spring_asymmetry" in said.what
    assert said.how_far.startswith("With them in the model, 49 %")


def test_a_cause_without_anything_left_is_not_called_a_part(made):
    diagnosis = made("partly")
    diagnosis["gap"]["structure_p_after"] = 0.4
    diagnosis["causes"][0]["probability"] = 0.7
    said = sentences(diagnosis)
    assert said.heading == "Causes were found, but not for certain"
    assert said.what.startswith("The likeliest causes: ")
    assert "contact_stribeck" in said.what
    assert said.left == ""


def test_certain_causes_that_do_not_predict_are_not_called_uncertain(made):
    diagnosis = made("partly")
    diagnosis["gap"]["structure_p_after"] = 0.4
    for cause in diagnosis["causes"]:
        cause["probability"] = 0.999
    said = sentences(diagnosis)
    assert said.heading == "Causes were found, but they do not explain all of what was not fitted"


def test_two_spans_of_one_file_are_told_apart(made):
    diagnosis = made("no_gap")
    diagnosis["gap"] |= {"unpredicted": True, "held_out": ["a.txt"]}
    diagnosis |= {"verdict": "unknown", "where": [], "causes": []}
    spans = [{"label": "a.txt[0,9]", "held_out": False}, {"label": "a.txt[9,20]", "held_out": True}]
    said = sentences(diagnosis | {"recordings": spans})
    assert said.where == "The gap shows in a.txt[9,20] alone."


def test_what_to_do_gives_way_to_the_sizes_of_causes(made):
    diagnosis = made("partly")
    diagnosis["causes"] *= 2
    for cause in diagnosis["causes"]:
        cause["remedy"] = "do something that takes a long sentence to say, " * 6
    lines = summary(diagnosis).splitlines()
    assert len(lines) <= 25
    assert any(line.startswith("cause ") for line in lines)
    assert not any(line.startswith("What to do") for line in lines)


def test_a_gap_that_grew_is_said_to(made):
    diagnosis = made("partly")
    diagnosis["gap"] |= {"shrink": -0.2, "shrink_ci95": None}
    assert "grew by 20 % of what could be removed." in sentences(diagnosis).how_far
    diagnosis["gap"] |= {"shrink": -0.3, "shrink_ci95": [-0.45, -0.12]}
    assert "grew by 30 %" in sentences(diagnosis).how_far
    assert "(95 % interval 12 % to 45 %)" in sentences(diagnosis).how_far


def test_a_gap_too_small_to_measure(made):
    diagnosis = made("partly")
    diagnosis["gap"] |= {"shrink": None, "removable_significant": False}
    assert "too close to the noise" in sentences(diagnosis).how_far


@pytest.mark.parametrize("separates", [["a"], ["a", "b"], ["a", "b", "c"], [], None])
@pytest.mark.parametrize("forced", [True, False])
def test_next_experiments(made, separates, forced):
    diagnosis = made("explained")
    diagnosis["next_experiment"] |= {"forced": forced, "separates": separates}
    last = summary(diagnosis).split("Next: ")[1]
    assert last.startswith("Drive the column" if forced else "Record a free decay")
    assert last.endswith(".")
    assert ",." not in last


def test_many_causes_and_long_sentences_fit(made):
    diagnosis = made("partly")
    diagnosis["causes"] = [
        cause | {"effect": f"{cause['effect']}_{i}" * 3}
        for i in range(5)
        for cause in diagnosis["causes"]
    ]
    diagnosis["confused_with"] = [["one", "two"]] * 9
    text = summary(diagnosis)
    assert len(text.splitlines()) <= 25
    assert "Next: " in text


@pytest.mark.parametrize(("groups", "end"), [(3, "; and 1 more group"), (5, "; and 3 more groups")])
def test_groups_beyond_those_shown_are_counted(made, groups, end):
    diagnosis = made("explained")
    diagnosis["confused_with"] = [["sensor1_eccentricity", "sensor1_nonlinearity"]] * groups
    lines = [line for line in summary(diagnosis).splitlines() if "cannot tell apart" in line]
    assert len(lines) == 2
    assert lines[-1].endswith(end)


def test_agreement_of_the_recordings(made):
    diagnosis = made("explained")
    said = sentences(diagnosis).agreement
    assert said == "It improves the fit in 5 of 6 recordings, and makes it worse in decay.csv."
    assert " ".join(summary(diagnosis).split()).count(said) == 1
    diagnosis["causes"][0]["agreement"] = {"improved": 1, "of": 1, "worse": []}
    assert sentences(diagnosis).agreement == ""
    diagnosis["causes"][0]["agreement"] = None
    assert sentences(diagnosis).agreement == ""
    assert sentences(made("no_gap")).agreement == ""


def test_what_to_do_about_a_cause(made):
    diagnosis = made("explained")
    said = sentences(diagnosis).remedy
    assert said == (
        "Clean the contact's surfaces, or use a pad of PTFE. To check it by hand: pull the rider "
        "slowly with a spring balance, and compare the two forces."
    )
    assert "What to do: Clean the contact's surfaces" in summary(diagnosis)
    second = {"effect": "spring_asymmetry", "remedy": "mount the spring without slack"}
    diagnosis["causes"].append(second)
    said = sentences(diagnosis).remedy
    assert "For contact_stribeck: clean" in said
    assert said.endswith("For spring_asymmetry: mount the spring without slack.")
    assert sentences(made("unknown")).remedy == ""


def test_a_candidate_that_is_likely_and_no_cause_says_why(made):
    diagnosis = made("explained")
    assert "why it is no cause" not in summary(diagnosis)
    row = next(r for r in diagnosis["candidates"] if r["effect"] == "contact_presliding")
    row["note"] = "with it held-out recordings are predicted worse"
    lines = summary(diagnosis).splitlines()
    head = next(line for line in lines if line.startswith("candidate"))
    assert head.endswith("why it is no cause")
    assert any(line.endswith(row["note"]) for line in lines)
    assert len(lines) <= 25
