"""scripts/stragglers: schedules that can be counted by hand."""

import json

import numpy as np
import pytest

from scripts import _stragglers
from scripts._stragglers import Run, main, simulate


class Chance:
    """Times until workers are lost, one after another."""

    def __init__(self, *times):
        self.times = list(times)

    def exponential(self, mean):
        return self.times.pop(0)


def test_each_piece_goes_to_the_worker_that_is_free_first():
    assert simulate([5.0, 1.0, 1.0, 1.0], 2, 0.0, None) == Run(5.0, 8.0, 0)
    assert simulate([1.0, 1.0, 1.0, 5.0], 2, 0.0, None) == Run(6.0, 8.0, 0)
    assert simulate([3.0], 8, 0.0, None) == Run(3.0, 3.0, 0)


def test_a_lost_piece_comes_first_again():
    # the first worker is lost after 2 s; the second takes its piece when it is free
    found = simulate([10.0, 3.0, 4.0], 2, 1.0, Chance(2.0, 99.0, 99.0, 99.0))
    assert found == Run(17.0, 19.0, 0)
    # its place is filled again after 30 s, before the other is free
    found = simulate([10.0, 100.0], 2, 1.0, Chance(2.0, 999.0, 99.0))
    assert found == Run(100.0, 112.0, 0)


def test_a_piece_that_kills_all_is_given_up():
    found = simulate([10.0], 1, 1.0, Chance(*[1.0] * 5))
    assert found == Run(4 * 31.0 + 1.0, 5.0, 1)


def test_losses_cost_what_they_should():
    rng = np.random.default_rng(0)
    run = simulate([60.0] * 2000, 50, 6.0, rng)
    # of exp(.1) - 1 attempts too many each lasts a little less than half
    assert run.spent_s / (60.0 * 2000) == pytest.approx(np.expm1(0.1) / 0.1, rel=0.02)


def test_the_table_goes_into_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(_stragglers, "FLEETS", ((4, 2),))
    ledger, page = tmp_path / "ledger.jsonl", tmp_path / "page.md"
    ledger.write_text("\n".join(json.dumps({"kind": "rough", "cpu_s": x}) for x in (5.0, 9.0)))
    page.write_text("A\n<!-- stragglers: begin -->\n<!-- stragglers: end -->\n")
    words = ["--ledger", str(ledger), "--page", str(page), "--runs", "3"]
    assert main(words) == 0
    assert "| 4 | 2 | 0 | " in page.read_text(encoding="utf-8")
    assert "2 measured times: median 7 s, 5 to 9 s." in capsys.readouterr().out
    ledger.write_text("")
    assert main(words) == 2
    assert "has no rigs of the kind rough" in capsys.readouterr().err
