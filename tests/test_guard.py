"""scripts/guard and scripts/nulls, on rows made up."""

import json

from scripts import _guard as guard
from scripts import _ledger
from scripts import _nulls as nulls
from tp_jax.executors import Ended


def row(verdict="explained", causes=("column_tilt",), shrink=0.9, cpu_s=40.0) -> guard.Row:
    return guard.Row(("column_tilt",), verdict, causes, shrink, cpu_s)


def test_rows_differ_by_verdict_causes_and_shrink():
    assert not row().differs(row(shrink=0.905, cpu_s=80.0))
    assert row().differs(row(verdict="unknown"))
    assert row().differs(row(causes=()))
    assert row().differs(row(shrink=0.92))
    assert row().differs(row(shrink=None))
    assert not row(shrink=None).differs(row(shrink=None))


def test_what_has_changed_is_shown():
    found = {"clean-case-001": row(), "rough-case-001": row("no_gap", (), None, 20.0)}
    other = {"clean-case-001": row("unknown", (), 0.0, 80.0)}
    told = guard._table(found, other, 24)
    assert "unknown → explained" in told
    assert "0.000 → 0.900" in told
    assert "2 of 24 rigs; 0 of 1 as before. CPU 80 → 40 s (0.50 times)." in told


def test_a_changed_rig_is_a_fault(tmp_path, monkeypatch, capsys):
    """All rigs are diagnosed already, so nothing is."""
    made = {"clean-case-001": (), "rough-case-001": ("column_tilt",)}
    monkeypatch.setattr(guard, "_made", lambda folder, executor: made)
    monkeypatch.setattr(guard, "KEPT", tmp_path / "trials" / "guard.json")
    now = tmp_path / guard.computed()[:12]  # rows of another program are none of this one's
    now.mkdir()
    for name in made:
        (now / f"{name}.json").write_text(json.dumps(guard.dataclasses.asdict(row())))
    words = ["--folder", str(tmp_path), "--made-only"]
    assert guard.main([*words, "--keep"]) == 0
    assert guard.main(words) == 0
    (now / "rough-case-001.json").write_text(json.dumps(guard.dataclasses.asdict(row(shrink=0.5))))
    assert guard.main(words) == 1
    assert "0.900 → 0.500" in capsys.readouterr().out
    assert guard.main([*words, "--keep"]) == 0
    assert "0.900 → 0.500" in capsys.readouterr().out  # what is kept from now on is told


def test_rows_of_other_campaigns_do_not_make_up_for_a_rig(tmp_path, monkeypatch):
    made = {"clean-case-001": (), "rough-case-001": ("column_tilt",)}
    monkeypatch.setattr(guard, "_made", lambda folder, executor: made)
    monkeypatch.setattr(guard, "KEPT", tmp_path / "trials" / "guard.json")
    monkeypatch.setattr(guard, "run_pieces", lambda *_, **__: [])  # as --limit-s ends it
    now = tmp_path / guard.computed()[:12]
    now.mkdir()
    for name in ("clean-case-001", "hard-campaign"):
        (now / f"{name}.json").write_text(json.dumps(guard.dataclasses.asdict(row())))
    assert guard.main(["--folder", str(tmp_path), "--made-only", "--keep"]) == 2
    assert not (tmp_path / "trials").exists()


def test_alarms_are_counted_by_kind():
    rows = [
        nulls.Row("slow", seed, "1", p, p < 0.05, (), 1e-3, 20.0)
        for seed, p in enumerate((0.5, 0.04, 5e-4))
    ]
    rows.append(nulls.Row("decay-drag", 1, "1", 1e-5, True, ("bearing_drag",), 2e-3, 60.0))
    slow, drag = nulls.table(rows).splitlines()[-2:]
    assert [cell.strip() for cell in slow.strip("|").split("|")] == [
        "slow",
        "3",
        "2 of 3",
        "2 of 3",
        "1 of 3",
        "–",
        "1.00 to 1.00 mrad",
        "20",
    ]
    assert "1 of 1" in drag


def test_a_ledger_goes_on_where_it_was(tmp_path, monkeypatch, capsys):
    looked = []

    def one(work, pieces, choice, *, until):
        for piece in pieces:
            looked.append(piece.arguments[:2])
            yield Ended(piece, nulls.Row(*piece.arguments, 0.5, False, (), 1e-3, 1.0))

    monkeypatch.setattr(_ledger, "run_pieces", one)
    words = ["--ledger", str(tmp_path / "l.jsonl"), "--kinds", "slow,rough", "--seeds"]
    assert nulls.main([*words, "1"]) == 0
    assert nulls.main([*words, "2"]) == 0
    assert looked == [("slow", 1), ("rough", 1), ("slow", 2), ("rough", 2)]
    assert capsys.readouterr().out.count("0 of 2") == 6
