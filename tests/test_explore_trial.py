"""scripts/explore_trial: a rig, resumed; the counting on results made up."""

import dataclasses
import json

import pytest

from scripts import _ledger
from scripts._explore_trial import STAND_IN, Row, hide, main, needed, read, table
from tp_jax.executors import Ended, Piece

ROW = Row(1, STAND_IN, "v", "a", 1.5, (None, "b", "a"), ("a", None, "a", "a"), "cause", 1.0)


@pytest.mark.parametrize(
    ("firsts", "runs"),
    [
        ((), None),
        (("a",), 1),
        (("b", "a"), 2),
        (("a", None), None),
        (("a", "b", "a", "a"), 3),
    ],
)
def test_runs_until_the_cause_is_named_for_good(firsts, runs):
    assert needed(firsts, "a") == runs


def test_the_table():
    later = dataclasses.replace(ROW, seed=2, swept=(None,) * 6)
    said = table([ROW, later, dataclasses.replace(ROW, seed=3, swept=("b",) * 5 + ("a",))])
    assert said.splitlines()[2] == "| stand-in | 3 | 3 | 3.00 | 2 | 4.50 | 1 of 2 |"
    assert "–" in table([later])


def test_a_line_that_was_cut_off_does_not_count(tmp_path):
    ledger = tmp_path / "explore.jsonl"
    whole = json.dumps(dataclasses.asdict(ROW))
    ledger.write_text(f"{whole}\n{whole[:30]}")
    assert read(ledger) == [ROW]
    assert read(tmp_path / "none") == []


def test_a_line_after_one_that_was_cut_off_stands_alone(tmp_path, monkeypatch):
    ledger = tmp_path / "explore.jsonl"
    whole = json.dumps(dataclasses.asdict(ROW))
    ledger.write_bytes(f"{whole}\n{whole}é".encode()[:-1])
    ended = Ended(Piece("2", (2, STAND_IN, "v")), dataclasses.replace(ROW, seed=2))
    monkeypatch.setattr(_ledger, "run_pieces", lambda *_, **__: [ended])
    assert main(["--rigs", "2", "--version", "v", "--ledger", str(ledger)]) == 0
    assert [row.seed for row in read(ledger)] == [1, 2]


def test_what_is_there_is_not_made_again(tmp_path, capsys):
    ledger = tmp_path / "explore.jsonl"
    ledger.write_text(json.dumps(dataclasses.asdict(ROW)) + "\n")
    before = ledger.read_bytes()
    assert main(["--rigs", "1", "--version", "v", "--ledger", str(ledger)]) == 0
    assert ledger.read_bytes() == before
    assert "| stand-in | 1 | 1 | 3.00 | 1 | 3.00 | 0 of 1 |" in capsys.readouterr().out


@pytest.mark.slow
def test_a_rig_has_one_effect_of_the_size_asked_for():
    hidden = hide(1)
    assert 1.0 <= hidden.multiple <= 2.0
    assert len(hidden.plan) == 6
    assert dataclasses.replace(hidden) == hide(1)
