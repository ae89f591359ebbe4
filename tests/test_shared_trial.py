"""scripts/shared_trial: fleets drawn from made-up screens, and the counts in a page."""

import dataclasses
import json

import numpy as np
import pytest

from scripts._shared_trial import draws, told
from scripts._shared_trial.__main__ import main
from scripts._shared_trial.draws import NOTHING, OWN, drawn_fleet, half_detectable, judged
from scripts._shared_trial.rigs import FLEETS, RIGS, file_of
from tests.shared_rigs import fleet, scores_of
from tp_jax.gap.shared.scores import write

BEGIN, END = "<!-- shared_trial: begin -->", "<!-- shared_trial: end -->"


@pytest.fixture(scope="module")
def rigs():
    return scores_of(fleet(0, n=10))


def test_an_amplitude_is_half_of_what_a_rig_detects(rigs):
    found = half_detectable(rigs, ("b", ()), np.random.default_rng(0))
    known = np.median([rig.information[1, 1] for rig in rigs])
    # z of power .95 at .01: 5 tests at .05 together
    assert abs(found[0]) * np.sqrt(known) == pytest.approx(0.5 * (2.576 + 1.645), rel=2e-3)


def test_drawn_scores_are_those_of_the_effect(rigs):
    every = [drawn_fleet(rigs, "b", n) for n in range(300)]
    scores = np.array([one[2].score for one in every])
    V = rigs[2].information
    plain = np.array([drawn_fleet(rigs, NOTHING, n)[2].score for n in range(300)])
    np.testing.assert_allclose(np.cov(plain.T), V, atol=0.35 * V.max())
    size = np.abs((scores @ np.linalg.inv(V))[:, 1])
    assert size.mean() > 1.5 * np.abs((plain @ np.linalg.inv(V))[:, 1]).mean()
    assert drawn_fleet(rigs, "unheard_of", 0) is None


def test_fleets_are_judged(rigs):
    some = [judged(drawn_fleet(rigs, "b", n), "b", n) for n in range(5)]
    assert sum(one.right for one in some) >= 4
    assert sum(one.alone for one in some) < 40
    nothing = [judged(drawn_fleet(rigs, NOTHING, n), NOTHING, n) for n in range(5)]
    assert all(one.right and not one.named for one in nothing)
    own = [judged(drawn_fleet(rigs, OWN, n), OWN, n) for n in range(5)]
    assert sum(one.right for one in own) >= 4
    assert sum(one.alone for one in own) > 25


@pytest.fixture
def study(tmp_path, monkeypatch):
    """One whole fleet, its ledger, a page."""
    monkeypatch.setattr(draws, "EFFECTS", ("b",))
    monkeypatch.setattr(told, "EFFECTS", ("b",))
    monkeypatch.setattr(draws, "DRAWS", 2)
    screens = tmp_path / "screens"
    screens.mkdir()
    row = {
        "version": "1",
        "effect": FLEETS[0],
        "sizes": [0.1],
        "structure_p": 0.4,
        "first": "b",
        "tied": [],
        "chi2_dof": 1.0,
        "cpu_s": 20.0,
    }
    lines = []
    for i, scores in enumerate(scores_of(fleet(1, n=RIGS, shared=(0, 0.4, 0, 0, 0, 0)))):
        write(file_of(screens, 1, i + 1), dataclasses.replace(scores, rig=f"rig-{i + 1}"))
        lines.append(json.dumps({**row, "fleet": 1, "rig": i + 1, "multiple": 0.4 + 0.02 * i}))
    (tmp_path / "shared.jsonl").write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "page.md").write_text(f"# A\n\n{BEGIN}\nold\n{END}\n\nB\n")
    return tmp_path


def test_the_counts_go_into_the_page(study, capsys):
    words = ["table", "--screens", str(study / "screens"), "--version", "1"]
    words += ["--ledger", str(study / "shared.jsonl"), "--page", str(study / "page.md")]
    assert main(words) == 0
    text = (study / "page.md").read_text(encoding="utf-8")
    assert text.startswith(f"# A\n\n{BEGIN}\n\n")
    assert text.endswith(f"\n\n{END}\n\nB\n")
    assert "old" not in text
    assert f"| {FLEETS[0]} | 0.4 to 0.62 | `b` | none | 0 of 12" in text
    assert "| nothing | 2 of 2: 1.00" in text
    assert capsys.readouterr().out.strip() in text


def test_faults_are_sentences(study, capsys):
    (study / "page.md").write_text("# A\n")
    words = ["--ledger", str(study / "shared.jsonl"), "--page", str(study / "page.md")]
    assert main(["table", "--screens", str(study / "screens"), *words]) == 2
    assert "lacks the line" in capsys.readouterr().err
    assert main(["table", "--screens", str(study), *words]) == 2
    assert "has too few screens" in capsys.readouterr().err
    assert main(["look", "--screens", "."]) == 2
    assert "outside" in capsys.readouterr().err


def test_single_rigs_are_counted_with_their_ties():
    line = {"structure_p": 0.001, "first": "c", "tied": ["c"]}
    assert told._seen_alone(line, "b")
    assert told._seen_alone(line, "")
    assert not told._seen_alone({**line, "tied": ["c", "d", "e"]}, "b")
    assert not told._seen_alone({**line, "structure_p": 0.5}, "b")
