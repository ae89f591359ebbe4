"""scripts/evidence: log evidences against integrals, their nulls, and the counting."""

import dataclasses

import numpy as np
import pytest
from scipy import integrate, stats

from scripts._evidence import comparison, evidence, saving, screens
from scripts._evidence.__main__ import main
from scripts._evidence.comparison import Answer, answer, null_scores, tables
from scripts._evidence.evidence import PRIORS, Prior, misfit, of_catalogue, of_sources
from scripts._evidence.screens import Saved, Variant
from trials.growing import rig

BLOCKS = 40
FREE = 60  # coefficients of a source


def screen(seed=0, hidden=None, size=0.0, *, limits=(-np.inf, np.inf), draws=400) -> Saved:
    """Noise, and perhaps one of three effects of 1, 2 and 1 amplitudes; no two resemble each other.

    Args:
        seed: of the noise. hidden: the effect. size: its first amplitude in standard errors.
        limits: of the first effect's amplitude. draws: of noise alone.
    """
    rng = np.random.default_rng(seed)
    V = np.diag([4.0, 9.0, 1.0, 100.0])
    variants = [("tilt", 0, 1), ("wear", 1, 2), ("drag", 3, 1)]
    root = np.sqrt(V / BLOCKS)
    blocks = rng.standard_normal((BLOCKS, 4)) @ root
    for name, first, _ in variants:
        if name == hidden:
            blocks[:, first] -= size * np.sqrt(V[first, first]) / BLOCKS
    score = blocks.sum(axis=0)

    def drop(first, count):
        return float((score**2 / np.diag(V))[first : first + count].sum())

    facts = {
        "rigs": "clean",
        "kind": "one" if hidden else "none",
        "cousins": {},
        "hidden": {hidden: {"location": hidden, "channel": "column", "multiple": 2.5}}
        if hidden
        else {},
        "cost": 1000.0,
        "dof": 1000,
        "coloured": False,
        "rounded": False,
        "floor_error": 0.03,
        "structure_p": 0.5,
        "free_p": 0.5,
        "excess": 0.0,
        "combined_p": 0.9,
    }
    value = np.full(FREE, 1.0)
    return Saved(
        facts,
        tuple(Variant(n, n, {}, first, q, drop(first, q)) for n, first, q in variants),
        score,
        V,
        np.full(4, 0.5),
        np.array([limits] + [(-np.inf, np.inf)] * 3),
        blocks,
        np.repeat((V / BLOCKS)[None], BLOCKS, axis=0),
        np.sqrt(V) @ rng.standard_normal((4, draws)),
        ("sensor1",),
        np.array([FREE]),
        value,
        rng.standard_normal(FREE),
    )


@pytest.mark.parametrize("limits", [(-np.inf, np.inf), (0.0, np.inf), (-0.2, 0.3)])
def test_an_evidence_is_the_integral_over_the_amplitude(limits):
    saved, V, sd = screen(3, limits=limits), 4.0, 0.5
    s = float(saved.score[0])

    def inside(a: float) -> float:
        return float(np.exp(-s * a - 0.5 * V * a**2) * stats.norm.pdf(a, scale=sd))

    ends = np.clip(limits, -8.0, 8.0)
    share = stats.norm.cdf(limits[1], scale=sd) - stats.norm.cdf(limits[0], scale=sd)
    wanted = np.log(integrate.quad(inside, *ends)[0] / share)
    one = np.array([sd / 0.5])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence, "SCALES", one)
        found = of_catalogue(saved, saved.score[:, None], PRIORS[0])["tilt"]
    assert found[0] == pytest.approx(wanted, abs=1e-9)


def test_shape_constants_are_averaged():
    saved = screen(1, "tilt", 6.0)
    alone = of_catalogue(saved, saved.score[:, None], PRIORS[0])
    other = dataclasses.replace(saved.variants[2], effect="tilt")  # of which nothing is seen
    both = dataclasses.replace(saved, variants=(*saved.variants[:2], other))
    found = of_catalogue(both, both.score[:, None], PRIORS[0])["tilt"][0]
    assert found == pytest.approx(np.logaddexp(alone["tilt"][0], alone["drag"][0]) - np.log(2.0))


@pytest.mark.parametrize("prior", PRIORS)
def test_what_is_hidden_has_the_most_evidence(prior):
    saved = screen(2, "drag", 8.0)
    found = of_catalogue(saved, saved.score[:, None], prior)
    assert max(found, key=lambda id: found[id][0]) == "drag"
    assert found["drag"][0] > 10.0
    assert max(of_sources(saved, prior).values()) < found["drag"][0]


def test_a_wrong_sign_has_no_evidence():
    seen = screen(2, "tilt", -8.0)
    bounded = screen(2, "tilt", -8.0, limits=(0.0, np.inf))
    free, held = (of_catalogue(x, x.score[:, None], PRIORS[0])["tilt"][0] for x in (seen, bounded))
    assert free > 10.0
    assert held < 0.0


def test_what_is_free_everywhere_is_something_else():
    saved = screen(4)
    loud = dataclasses.replace(saved, free=3.0 * saved.free)
    quiet, seen = (of_sources(x, PRIORS[0])["something else: sensor1"] for x in (saved, loud))
    assert quiet < 1.0 < 20.0 < seen


def test_evidence_is_tempered_by_the_misfit_of_the_best():
    saved = screen(2, "drag", 8.0)
    wrong = dataclasses.replace(saved, facts=saved.facts | {"cost": 4000.0})
    assert misfit(saved) == 1.0
    assert misfit(wrong) == pytest.approx(4.0, abs=0.1)
    at = [
        of_catalogue(x, x.score[:, None], Prior("any", told=True))["drag"][0]
        for x in (saved, wrong)
    ]
    assert 3.0 < at[0] / at[1] < 6.0


@pytest.mark.parametrize("way", comparison.NULLS)
def test_noise_alone_is_drawn_as_it_scatters(way):
    saved = screen(5, draws=4000)
    score, level = null_scores(saved, way)
    assert score.shape == (4, comparison.DRAWS)
    assert level.shape == (comparison.DRAWS,)
    assert np.std(score, axis=1) == pytest.approx(np.sqrt(np.diag(saved.information)), rel=0.35)


def test_noise_alone_rarely_alarms():
    p = [answer(screen(seed)).p for seed in range(40)]
    for way in p[0]:
        if way.startswith(PRIORS[0].name):
            assert sum(each[way] < 0.1 for each in p) <= 10
            assert sum(each[way] < 0.5 for each in p) >= 8


def test_a_screen_comes_back_as_it_was_saved(tmp_path):
    saved, file = screen(6, "wear", 5.0), tmp_path / "clean-00001.npz"
    screens.write(file, saved)
    again = screens.read(file)
    assert again.facts == saved.facts
    assert again.variants == saved.variants
    assert again.sources == saved.sources
    for name in ("score", "information", "blocks", "noise", "free", "ends"):
        np.testing.assert_allclose(getattr(again, name), getattr(saved, name), rtol=1e-6)
    file.write_bytes(file.read_bytes()[:-100])
    assert screens.read(file) is None
    assert screens.read(tmp_path / "none.npz") is None


def test_counts():
    def rig(kind, multiple, today, other):
        ways = {comparison.TODAY: today} | {prior.name: other for prior in PRIORS}
        p = {"today, all tests": 0.5 if kind == "none" else 0.01}
        known = None if kind == "none" else ways
        return Answer("clean", kind, multiple, p, known, known, known, dict.fromkeys(ways, other))

    told = tables(
        [
            rig("none", None, False, False),
            rig("one", 1.5, True, False),
            rig("one", 4.0, False, True),
            rig("one", 2.5, False, True),
        ]
    )
    cells = [line.strip("| ").split(" | ") for line in told.splitlines() if line.startswith("| t")]
    today, first = cells[0], cells[1]
    assert today[1].startswith("0.33")
    assert first[1].startswith("0.67")
    assert first[2].startswith("0.00")
    assert first[-1] == "2 : 1 (p 1)"
    asked = next(row for row in cells if row[0] == "today, all tests")
    assert asked[1].startswith("0.00")
    assert asked[-1] == "1.00"
    assert told.splitlines()[-1].split(" | ")[1:] == [
        "0.00 (0.00–0.79), n 1",
        "0.67 (0.21–0.94), n 3 |",
    ]


def test_screens_that_are_there_are_not_made_again(tmp_path, monkeypatch):
    screens.write(saving.file_of(tmp_path, "clean", 1), screen())
    asked = []
    monkeypatch.setattr(saving, "run_pieces", lambda _, left, *a, **k: asked.extend(left) or [])
    monkeypatch.setattr(saving.os, "nice", lambda _: 0)
    assert main(["save", "--to", str(tmp_path), "--clean", "4", "--rough", "2"]) == 0
    assert [(number, rigs) for _, number, rigs in (piece.arguments for piece in asked)] == [
        (2, "clean"),
        (1, "rough"),
        (3, "clean"),
        (4, "clean"),
        (2, "rough"),
    ]


@pytest.mark.parametrize("rigs", saving.PARTS)
def test_a_third_of_the_rigs_hides_nothing(rigs):
    parts = saving.PARTS[rigs]
    kinds = [rig(n, saving.SEED, rigs, parts).kind for n in range(1, 25)]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {k: 2 * n for k, n in parts.items()}
    assert kinds.count("none") == 8


def test_faults_are_told_in_one_sentence(tmp_path, capsys):
    inside = str(saving.Path(saving.__file__).parent / "screens")
    assert main(["save", "--to", inside]) == 2
    assert "a folder outside" in capsys.readouterr().err
    assert main(["table", "--of", str(tmp_path)]) == 2
    assert "holds no saved screens" in capsys.readouterr().err
