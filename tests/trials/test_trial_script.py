"""What scripts/blind makes of a trial whose cases are all diagnosed."""

import itertools
import json

import pytest

import trials
from scripts._blind import __main__ as study
from tests.trials.test_score import CASES
from tp_jax.executors import ExecutorChoice
from trials import score


def test_score_and_tables(trial, tmp_path, capsys):
    root = trial(*CASES)
    page = tmp_path / "trial.md"
    words = [str(root), "--cases", "7", "--quick", "--markdown", str(page)]
    assert study.main(words) == 0
    assert json.loads((root / "score.json").read_text())["cases"] == 7
    said = capsys.readouterr()
    assert "goes on with the cases, rigs and seed that it was made with" in said.err
    told = said.out
    lines = page.read_text().splitlines()
    for words in ("false alarms, nothing hidden", "motor_stall", "by effect, alone in its rig"):
        assert words in told
        assert any(words in line for line in lines)
    # every line of a table has as many cells as its head
    widths = [line.count("|") for line in lines]
    for before, after in itertools.pairwise(widths):
        assert not (before and after) or before == after
    assert "seed 5" in lines[-1]  # that of the trial, which was there already


def test_a_page_that_cannot_be_written_is_told_of_first(tmp_path, capsys):
    assert study.main([str(tmp_path / "none"), "--markdown", str(tmp_path)]) == 2
    assert "it is a folder" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


def test_scores_of_other_trials_are_pooled(trial, tmp_path, capsys):
    root = trial(*CASES)
    other = tmp_path / "other.json"
    other.write_text(json.dumps(score(root) | {"keys": ["of another trial"]}))
    page = tmp_path / "trial.md"
    words = [str(root), "--quick", "--pool", str(other), "--markdown", str(page)]
    assert study.main(words) == 0
    assert page.read_text().startswith("14 cases:")
    assert json.loads((root / "score.json").read_text())["cases"] == 7
    assert study.main([str(root), "--pool", str(page)]) == 2
    assert "is no score of a trial" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--quick"], ["run", "--quick"]])
def test_a_folder_alone_is_run(words, trial, capsys):
    root = trial(*CASES)
    at = 1 if words[0] == "run" else 0
    assert study.main([*words[:at], str(root), *words[at:]]) == 0
    assert (root / "score.json").is_file()
    assert "motor_stall" in capsys.readouterr().out


def test_score_alone(trial, capsys):
    root = trial(*CASES)
    assert study.main(["score", str(root), "--quick", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "tp-jax/blind/1"
    assert found["cases"] == 7
    assert not (root / "score.json").exists()


def test_make_alone(tmp_path, monkeypatch, capsys):
    asked = []

    def made(*given, **more):
        asked.append((given, more))
        return "ab"

    monkeypatch.setattr(trials, "make", made)
    words = ["make", str(tmp_path / "t"), "--cases", "4", "--rigs", "rough", "--workers", "9"]
    assert study.main([*words, "--seed", "5"]) == 0
    ((given, more),) = asked
    assert given == (str(tmp_path / "t"), 4, 5)
    assert (more["rigs"], more["executor"]) == ("rough", ExecutorChoice("local", 9))
    assert "Made 4 cases" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["make", "b", "--cases", "9" * 11], "--cases must be at most 100000"),
        (["make", "b", "--workers", "9" * 11], "--workers must be at most 1000"),
        (["make", "/dev/null/b", "--cases", "1"], "Cannot make the folder /dev/null"),
        (["score", "nowhere"], "nowhere holds no blind trial"),
    ],
)
def test_bad_arguments_are_told_in_one_sentence(words, part, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert study.main(words) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert part in told.err
