"""The study of many starts: what it counts, and a small one from end to end."""

import json

import pytest

from scripts import _multistart as study


def rig(above, good):
    row = {"truth": 1.0, "value": 1.0, "ci95": [0.9, 1.1], "identifiable": True, "good": good}
    return {"above": above, "parameters": {"k": row}, "seconds": 2.0}


def test_starts_are_counted_without_the_datas_own():
    found = study.tally({0: rig([0.0, 0.5, 1.5, None], True), 1: rig([3.0, 0.0, 0.2, 0.3], False)})
    reached = found["starts_that_reach_the_best"]
    assert (reached["held"], reached["of"]) == (4, 6)
    assert found["the_datas_own"]["held"] == 1
    assert (found["good"]["k"]["held"], found["good"]["k"]["of"]) == (1, 2)
    assert "4/6" in study.lines(found)[0]


def test_nothing_done_is_said():
    assert study.lines(study.tally({})) == ["No rig is done."]


@pytest.mark.slow
def test_a_small_study_and_its_resumption(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TP_JAX_CACHE", "off")
    words = ["--quick", "--rigs", "1", "--starts", "2", "--out", str(tmp_path)]
    assert study.main(words) == 0
    kept = (tmp_path / "rigs.jsonl").read_text()
    result = json.loads((tmp_path / "multistart.json").read_text())
    assert result["starts_that_reach_the_best"]["of"] == 2
    assert result["good"]["k"]["held"] == 1
    assert study.main(words) == 0
    assert (tmp_path / "rigs.jsonl").read_text() == kept
    for other in (["--seed", "1"], ["--raw-starts"]):
        assert study.main([*words, *other]) == 2
    assert "other settings" in capsys.readouterr().err
