"""What scripts/blind makes of a trial whose cases are all diagnosed."""

import itertools
import json

from scripts import _blind as study
from tests.blind.test_score import CASES
from tp_jax.blind import score


def test_score_and_tables(trial, tmp_path, capsys):
    root = trial(*CASES)
    page = tmp_path / "trial.md"
    words = [str(root), "--cases", "7", "--quick", "--markdown", str(page)]
    assert study.main(words) == 0
    assert json.loads((root / "score.json").read_text())["cases"] == 7
    told = capsys.readouterr().out
    lines = page.read_text().splitlines()
    for words in ("false alarms, nothing hidden", "motor_stall", "by effect, alone in its rig"):
        assert words in told
        assert any(words in line for line in lines)
    # every line of a table has as many cells as its head
    widths = [line.count("|") for line in lines]
    for before, after in itertools.pairwise(widths):
        assert not (before and after) or before == after
    assert "seed 0" in lines[-1]


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
