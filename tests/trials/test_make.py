"""Making trials: the same for the same seed, nothing that tells, nothing of the model."""

import hashlib
import importlib
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from scripts._blind.__main__ import main
from tp_jax.errors import InputError
from tp_jax.recordings import load_campaign
from tp_jax.rig import BENCH
from tp_jax.rig.effects import catalogue
from trials import make
from trials.case import LARGEST, SMALLEST, Settings, make_case
from trials.draw import draw_rig, usable
from trials.plan import counts, plan_cases

TINY = Settings(runs=3, sealed_runs=2, duration=2.0, rate=100.0)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("blind") / "trial"
    make(root, 4, 1, settings=TINY)
    return root


def files(root: Path) -> dict[str, bytes]:
    return {str(p.relative_to(root)): p.read_bytes() for p in root.rglob("*") if p.is_file()}


def key_of(root: Path) -> dict:
    return json.loads((root / "sealed" / "key.json").read_text())


def test_kinds_in_proportion():
    assert counts(440) == {"one": 200, "none": 120, "outside": 60, "two": 60}
    assert sum(counts(7).values()) == 7
    assert Counter(case.kind for case in plan_cases(440, 3)) == counts(440)


def test_effects_take_turns():
    plan = plan_cases(440, 3)
    first = Counter(case.preferred[0] for case in plan if case.kind == "one")
    inside = {e.id for e in catalogue().values() if e.in_catalogue}
    assert set(first) == inside
    assert max(first.values()) - min(first.values()) <= 1
    assert all(set(case.preferred) == inside for case in plan if case.kind in ("one", "two"))
    assert all(inside.isdisjoint(case.preferred) for case in plan if case.kind == "outside")
    assert plan == plan_cases(440, 3) != plan_cases(440, 4)


def test_kinds_are_not_in_order():
    kinds = [case.kind for case in plan_cases(44, 0)]
    assert kinds != sorted(kinds)


def test_layout(made):
    names = [f"case-{i:03d}" for i in range(1, 5)]
    assert sorted(p.name for p in made.iterdir()) == ["KEY.sha256", *names, "sealed"]
    assert sorted(p.name for p in (made / "sealed").iterdir()) == [*names, "key.json"]
    for name in names:
        assert len(load_campaign(made / name).recordings) == 3
        assert len(load_campaign(made / "sealed" / name).recordings) == 2


def test_the_hash_commits_to_the_key(made):
    digest, name = (made / "KEY.sha256").read_text().split()
    assert hashlib.sha256((made / name).read_bytes()).hexdigest() == digest


def test_the_key_holds_what_is_hidden(made):
    key = key_of(made)
    for entry in key["cases"]:
        hidden = entry["given"]["effects"]
        assert len(hidden) == {"none": 0, "one": 1, "outside": 1, "two": 2}[entry["kind"]]
        assert all(e["in_catalogue"] != (entry["kind"] == "outside") for e in hidden.values())
        # the sealed runs are of the same rig, with the same effects, on other occasions
        assert entry["sealed"]["effects"] == hidden
        assert entry["sealed"]["parameters"] == entry["given"]["parameters"]
        assert entry["sealed"]["runs"] != entry["given"]["runs"][:2]
        for each in entry["reference"].values():
            assert SMALLEST <= each["multiple"] <= LARGEST
        campaign = load_campaign(made / entry["case"])
        assert campaign.data_sha256 == entry["sha256"]


def test_given_files_do_not_tell(made):
    words = {*catalogue(), "seed", "effect"}
    for name, data in files(made).items():
        if name.startswith("case-") and name.endswith(".toml"):
            assert not any(word in data.decode() for word in words)


def test_clean_trials_stay_what_they_are(made):
    """Published trials can be made again: of these seeds, kinds, rigs, noise and runs."""
    plan = [[c.name, c.kind, c.seed, c.preferred] for c in plan_cases(44, 3)]
    # an effect that joins the catalogue may change it, cousins may not
    digest = hashlib.sha256(json.dumps(plan).encode()).hexdigest()
    assert digest.startswith("02fa5e7b44c63650")
    run = load_campaign(made / "case-003").recordings[1]
    assert run.phi2 is not None
    # the last digits are the processor's
    text = np.array2string(np.round([run.phi1, run.phi2], 9), threshold=10**6)
    assert hashlib.sha256(text.encode()).hexdigest().startswith("2bf4a709745fdd32")
    assert "rigs" not in key_of(made)


@pytest.mark.slow
def test_same_seed_same_trial(made, tmp_path):
    digest = make(tmp_path / "again", 4, 1, settings=TINY)
    assert files(tmp_path / "again") == files(made)
    assert digest in (made / "KEY.sha256").read_text()


def test_goes_on_where_it_was(tmp_path, monkeypatch):
    source = importlib.import_module("trials.make")
    asked = []

    def failing(part, case, settings):
        asked.append(case.name)
        if len(asked) == 2:
            raise KeyboardInterrupt
        folder = part / "sealed" / case.name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "key.json").write_text("{}")
        return {"case": case.name}

    monkeypatch.setattr(source, "make_case", failing)
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "t", 3, 0)
    assert not (tmp_path / "t").exists()
    assert (tmp_path / ".t.part" / "sealed" / asked[0] / "key.json").is_file()
    make(tmp_path / "t", 3, 0)
    assert [p.name for p in tmp_path.iterdir()] == ["t"]


def test_what_another_program_began_is_begun_anew(tmp_path, monkeypatch):
    source = importlib.import_module("trials.make")
    part = tmp_path / ".t.part"
    assert source._begin(part, {"cases": 3}, "one") is None
    (part / "case-001").mkdir()
    assert source._begin(part, {"cases": 3}, "one") is None
    assert (part / "case-001").is_dir()
    assert source._begin(part, {"cases": 3}, "two") is None
    assert not (part / "case-001").exists()


@pytest.mark.parametrize("at", ["rmdir", "rename"])
def test_cut_off_while_it_is_put_into_its_place(at, tmp_path, monkeypatch):
    source = importlib.import_module("trials.make")
    asked = []

    def made_of(part, case, settings):
        asked.append(case.name)
        (part / "sealed" / case.name).mkdir(parents=True)
        return {"case": case.name}

    monkeypatch.setattr(source, "make_case", made_of)
    (tmp_path / "t").mkdir()
    with monkeypatch.context() as cut:
        cut.setattr(Path, at, lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            make(tmp_path / "t", 3, 0)
    make(tmp_path / "t", 3, 0)
    assert len(asked) == 3  # none was made again
    assert [p.name for p in tmp_path.iterdir()] == ["t"]
    assert not list((tmp_path / "t").rglob("trial.json"))
    with pytest.raises(InputError, match="not empty"):
        make(tmp_path / "t", 3, 1)


def test_half_a_part_of_the_key_is_made_again(tmp_path):
    case = plan_cases(4, 1)[0]
    entry = make_case(tmp_path, case, TINY)
    part = tmp_path / "sealed" / case.name / "key.json"
    text = part.read_text()
    part.write_text(text[: len(text) // 2])
    assert make_case(tmp_path, case, TINY) == entry
    assert part.read_text() == text


def test_a_folder_with_something_in_it(tmp_path, capsys):
    (tmp_path / "notes").write_text("")
    with pytest.raises(InputError, match="is not empty"):
        make(tmp_path, 4)
    assert main(["make", str(tmp_path), "--cases", "4"]) == 2
    assert "is not empty" in capsys.readouterr().err
    with pytest.raises(InputError, match="at least one case"):
        make(tmp_path / "t", 0)


def test_rigs_move():
    rng = np.random.default_rng(0)
    for _ in range(3):
        parameters, _, plan = draw_rig(rng, 6, 4.0)
        assert usable(parameters, plan, 4.0)
        assert 0.5 <= parameters.k / BENCH.k <= 1.5
        assert len(plan) == 6


def test_rigs_that_do_not_are_refused():
    import dataclasses

    plan = [{"release": 0.5}, {"omega": 9.0}, {"omega": 13.0}]
    assert not usable(dataclasses.replace(BENCH, M1=1.0), plan, 3.0)
    assert not usable(dataclasses.replace(BENCH, Ts1=1.0), plan, 3.0)


def test_making_loads_no_model():
    code = (
        "import sys, trials\n"
        "names = {n.split('.')[0] for n in sys.modules}\n"
        "assert not names & {'jax', 'equinox', 'diffrax'}, names\n"
        "parts = {n.split('.')[1] for n in sys.modules if n.startswith('tp_jax.')}\n"
        "assert not parts & {'model', 'effects', 'simulation', 'estimation', 'gap'}, parts\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[2])
