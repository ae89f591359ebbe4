"""scripts/blind pool: a trial that grows, on a stand-in for the diagnosis."""

import dataclasses
import json

import pytest

from scripts import _ledger
from scripts._blind import pool
from scripts._blind.__main__ import main
from tests.trials.conftest import diagnosis_of, part_of_key
from tp_jax.executors import Ended
from trials.growing import PLANNED, rig

SEALED = {"shrink": 0.9, "best": 0.95, "harm_windowed": False, "harm_free_run": None}
FOUND = diagnosis_of("explained", ["column_tilt"], least={"column_tilt": 0.01}, shrink=0.8) | {
    "causes": [{"effect": "column_tilt", "parameters": {}, "probability": 0.97}]
}
QUIET = diagnosis_of("no_gap")


def answer(rigs: str, number: int, name: str, commit: str | None, version: str) -> pool.Row:
    """What a stand-in finds: odd rigs hide a tilt, even ones nothing."""
    case = rig(number, pool.seed_of(name), rigs)
    hidden = {"column_tilt": 0.04} if number % 2 else {}
    entry = part_of_key(case.name, "one" if hidden else "none", hidden)
    found, sealed = (FOUND, SEALED) if hidden else (QUIET, dict.fromkeys(SEALED))
    return pool.row_of(entry, found, sealed, number, case.seed, rigs, commit, version, 30.0)


@pytest.fixture
def pools(tmp_path, monkeypatch):
    """Folder of the pools; every call looks at three rigs, by the stand-in."""
    monkeypatch.setattr(pool, "POOLS", tmp_path)
    monkeypatch.setattr(pool, "FOLDER", tmp_path / "in-hand")
    monkeypatch.setattr(pool, "_version", lambda: ("v1", "c1"))

    def three(_, pieces, *args, **kwargs):
        return [Ended(piece, answer(*piece.arguments)) for piece in pieces[:3]]

    monkeypatch.setattr(_ledger, "run_pieces", three)
    return tmp_path


def test_calls_add_rigs_and_never_one_twice(pools, capsys):
    assert main(["pool", "demo"]) == 0
    assert main(["pool", "demo"]) == 0
    rows = pool.read(pools / "demo.jsonl")
    assert [row.number for row in rows] == [1, 2, 3, 4, 5, 6]
    assert len({row.seed for row in rows}) == 6
    assert "3 added, 6 rigs in all" in capsys.readouterr().out


def test_a_line_says_what_was_hidden_and_what_was_found(pools):
    main(["pool", "demo"])
    line = json.loads((pools / "demo.jsonl").read_text().splitlines()[0])
    assert line["hidden"] == {"column_tilt": {"sizes": [0.04], "multiple": 4.0}}
    assert (line["verdict"], line["causes"]) == ("explained", ["column_tilt"])
    assert (line["detectable"], line["shrink"], line["probability"]) == (4.0, 0.8, 0.97)
    assert line["sealed"] == SEALED
    assert (line["version"], line["commit"], line["cpu_s"]) == ("v1", "c1", 30.0)


def test_a_rig_whose_line_was_cut_off_is_looked_at_again(pools):
    main(["pool", "demo"])
    ledger = pools / "demo.jsonl"
    ledger.write_bytes(ledger.read_bytes()[:-40])
    assert [row.number for row in pool.read(ledger)] == [1, 2]
    assert main(["pool", "demo"]) == 0
    assert [row.number for row in pool.read(ledger)] == [1, 2, 3, 4, 5]


def test_a_rig_counts_once(pools):
    main(["pool", "demo"])
    ledger = pools / "demo.jsonl"
    ledger.write_text(ledger.read_text() * 2)
    assert len(pool.read(ledger)) == 3


def test_versions_are_counted_apart(pools, monkeypatch, capsys):
    main(["pool", "demo"])
    monkeypatch.setattr(pool, "_version", lambda: ("v2", None))
    main(["pool", "demo"])
    before = (pools / "demo.jsonl").read_bytes()
    capsys.readouterr()
    page = pools / "page.md"
    assert main(["pool", "demo", "--score", "--markdown", str(page)]) == 0
    assert (pools / "demo.jsonl").read_bytes() == before
    told = capsys.readouterr().out
    assert page.read_text() == told
    rows = [line for line in told.splitlines() if line[:4] in ("| v1", "| v2")]
    one, two = ([cell.strip() for cell in row.strip("|").split("|")] for row in rows)
    assert one[:4] == ["v1", "c1", "3", "1.00 (0.34–1.00), n 2"]
    assert one[5] == "0.00 (0.00–0.79), n 1"
    assert two[:4] == ["v2", "none", "3", "1.00 (0.21–1.00), n 1"]
    # all tables are of the version that was tried last
    assert "\n3 cases:\n" in told
    assert "| false alarms, nothing hidden | 0.00 (0.00–0.66), n 2 | – |" in told
    # and of several together, where they are asked for
    assert main(["pool", "demo", "--score", "--version", "v1,v2"]) == 0
    assert "\n6 cases:\n" in capsys.readouterr().out


def test_a_pool_goes_on_after_a_rig_that_took_longer_than_a_call(pools):
    main(["pool", "demo"])
    ledger = pools / "demo.jsonl"
    slow = [dataclasses.replace(row, cpu_s=1300.0) for row in pool.read(ledger)]
    ledger.write_text("".join(json.dumps(dataclasses.asdict(row)) + "\n" for row in slow))
    assert main(["pool", "demo", "--minutes", "1"]) == 0
    assert len(pool.read(ledger)) == 6


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["Demo"], "NAME must be of a-z"),
        (["demo", "--minutes", "21"], "--minutes must be at most 20"),
        (["none", "--score"], "The pool none is empty"),
        (["demo", "--rigs", "rough"], "is of clean rigs"),
        (["demo", "--score", "--version", "v9"], "no rigs of the version v9"),
    ],
)
def test_faults_are_told_in_one_sentence(words, part, pools, capsys):
    main(["pool", "demo"])
    capsys.readouterr()
    assert main(["pool", *words]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert part in told


def test_two_calls_do_not_draw_the_same(pools, capsys):
    pytest.importorskip("fcntl")
    with pool._held("demo"):
        assert main(["pool", "demo"]) == 2
    assert "Another call adds to the pool demo" in capsys.readouterr().err
    assert not (pools / "demo.jsonl").exists()


def test_the_rigs_of_a_pool_are_an_endless_fair_row():
    kinds = [rig(n, 5).kind for n in range(1, 2 * PLANNED["clean"] + 1)]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        "one": 40,
        "none": 24,
        "outside": 12,
        "two": 12,
    }
    assert rig(45, 5) == rig(45, 5) != rig(45, 6)
    assert len({rig(n, 5).seed for n in range(1, 89)}) == 88
    assert rig(3, 5, "rough").name == "rough-00003"


@pytest.mark.slow
def test_a_rig_is_made_diagnosed_and_forgotten(tmp_path, monkeypatch):
    """Of the real thing all but the fits."""
    import scripts._blind.run as run
    from scripts._version import computed
    from trials import harm, sealed_runs
    from trials.seal import diagnosis_file
    from trials.written import sha256

    def quiet(root, name, without=()):
        digests = {f.name: sha256(f) for f in (root / name).glob("run-*.csv")}
        file = diagnosis_file(root, name)
        file.parent.mkdir()
        file.write_text(json.dumps(QUIET | {"provenance": {"data_sha256": digests}}))

    monkeypatch.setattr(pool, "FOLDER", tmp_path)
    monkeypatch.setattr(run, "diagnose_case", quiet)
    monkeypatch.setattr(sealed_runs, "measured", lambda *_: {"shrink": None, "best": None})
    monkeypatch.setattr(harm, "measured_harm", lambda *_: harm.NOTHING)
    row = pool.look("clean", 1, "demo", None, computed()[: pool.DIGITS])
    assert (row.number, row.verdict, row.causes) == (1, "no_gap", [])
    assert not list((tmp_path / "demo").iterdir())
