"""tp-jax diagnose of several campaigns, each by a stand-in for its diagnosis."""

import csv
import json
from pathlib import Path

import pytest

from tests.cli import stand_in_rig
from tests.cli.stand_in_rig import campaign
from tp_jax.cli import fleet, main
from tp_jax.cli.fleet import campaigns_of, diagnose_rig, names_of
from tp_jax.errors import InputError
from tp_jax.executors import Ended, ExecutorChoice
from tp_jax.executors.calls import Fault

OK = ("explained-1", "explained-2", "no_gap-1", "unknown-1", "single-1")


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """A folder `rigs` of five campaigns; the working folder is beside it."""
    monkeypatch.setattr(fleet, "WORK", stand_in_rig.diagnose_rig)
    monkeypatch.chdir(tmp_path)
    for name in OK:
        campaign(tmp_path / "rigs" / name)
    return tmp_path


def begun(here: Path) -> dict[str, int]:
    files = sorted((here / "rigs").glob("*/begun.txt"))
    return {f.parent.name: len(f.read_text().splitlines()) for f in files}


def test_one_campaign_is_no_fleet(here):
    assert campaigns_of([]) is None
    assert campaigns_of(["nowhere"]) is None
    assert campaigns_of(["rigs/no_gap-1"]) is None
    assert campaigns_of([str(here)]) is None, "campaigns lie one folder deeper"
    assert campaigns_of(["rigs/no_gap-1/campaign.toml"]) is None


def test_several_campaigns_or_a_folder_of_them_are_a_fleet(here):
    every = [Path("rigs") / name for name in sorted(OK)]
    assert campaigns_of(["rigs"]) == every
    assert campaigns_of([str(each) for each in every]) == every
    assert campaigns_of(["rigs/unknown-1", "rigs"])[0] == Path("rigs/unknown-1")
    assert len(campaigns_of(["rigs/unknown-1", "rigs"])) == 5, "each once"
    assert campaigns_of(["a.csv", "b.csv"]) == [Path("a.csv"), Path("b.csv")]


def test_fits_of_another_program_are_begun_anew(tmp_path, monkeypatch):
    """An unfinished rig whose fits lead nowhere is not lost, nor is a fault done twice."""
    rig = fleet.Rig("a", campaign(tmp_path / "a"), tmp_path / "out")
    rig.folder.mkdir()
    (rig.folder / fleet.FITS).write_text("of another")
    asked = []

    def diagnosed(_campaign, _folder, *, resume, **_):
        asked.append(resume)
        if resume or "fault" in said:
            raise InputError("Cannot resume.")
        return {}

    said = set()
    monkeypatch.setattr(fleet, "load", lambda *_: None)
    monkeypatch.setattr(fleet, "diagnosed", diagnosed)
    monkeypatch.setattr("tp_jax.report.fleet.rows.row", lambda *_: {})
    diagnose_rig(rig)
    assert asked == [True, False]
    assert not (rig.folder / fleet.FITS).exists()
    said.add("fault")
    with pytest.raises(InputError):
        diagnose_rig(rig)
    assert asked == [True, False, False]


def test_the_calibration_of_a_single_file_counts(tmp_path):
    run = tmp_path / "a.csv"
    run.write_text("t,phi1\n")
    rig = fleet.Rig("a", run, tmp_path / "out", omega=1.0)
    before = fleet._of(rig)
    (tmp_path / "a.csv.meta.json").write_text("{}")
    assert fleet._of(rig) != before


def test_names_differ_and_name_folders(tmp_path):
    paths = [tmp_path / each for each in ("a/rig", "b/rig", "b/Rig", "pieces", "ä b/ö (2)")]
    for path in paths:
        path.mkdir(parents=True)
    runs = [tmp_path / "run 1.csv", tmp_path / "run 1.txt"]
    assert names_of([*paths, *runs]) == [
        "rig",
        "rig-2",
        "Rig-3",
        "pieces-2",
        "ö-2",
        "run-1",
        "run-1-2",
    ]


def test_a_fleet_leaves_a_table_a_page_and_a_folder_for_each_rig(here, capsys):
    assert main(["diagnose", "rigs", "--workers", "2"]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.startswith("5 rigs: 3 explained, 1 unknown, 1 no gap\n")
    assert told.out.endswith("\nFleet: rigs-diagnosis/fleet.html\n")
    out = here / "rigs-diagnosis"
    found = json.loads((out / "fleet.json").read_text())
    assert found["schema"] == "tp-jax/fleet/1"
    assert found["verdicts"] == {"explained": 3, "unknown": 1, "no_gap": 1, "failed": 0}
    rows = {row["rig"]: row for row in found["rigs"]}
    assert set(rows) == set(OK)
    first = rows["explained-1"]
    assert (first["cause"], first["location"], first["channel"]) == (
        "contact_stribeck",
        "contact",
        "contact",
    )
    assert (first["parameter"], first["value"], first["shrink"]) == ("strength", 0.58, 0.98)
    assert (first["value_low"], first["value_high"]) == (0.55, 0.61)
    assert first["confused_with"] == "contact_presliding"
    assert rows["no_gap-1"]["cause"] is None
    for row in rows.values():
        assert (out / row["report"]).is_file()
    with (out / "fleet.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["rig"] for line in lines] == [row["rig"] for row in found["rigs"]]
    assert float(lines[0]["shrink"]) == found["rigs"][0]["shrink"]
    assert 'href="explained-1/report.html"' in (out / "fleet.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_same_fleet_has_the_same_table_whatever_the_executor(here, capsys):
    tables = []
    for words in (["--workers", "1"], ["--workers", "3", "--seed", "0"]):
        assert main(["diagnose", "rigs", "--json", "-", *words]) == 0
        tables.append(json.loads(capsys.readouterr().out))
    for table in tables:
        table["provenance"].pop("wall_s")
    assert tables[0] == tables[1]


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "code"), [(["faulty"], 2), (["faulty", "broken"], 1)])
def test_a_rig_that_fails_is_a_row_with_its_sentence(here, capsys, kinds, code):
    for kind in kinds:
        campaign(here / "rigs" / f"{kind}-1")
    assert main(["diagnose", "rigs", "--out", "out", "--workers", "2"]) == code
    told = capsys.readouterr()
    assert "faulty-1: " in told.out
    assert "/run.csv has no column t; add one.\n" in told.out
    assert told.err == (
        f"tp-jax: {len(kinds)} of {5 + len(kinds)} rigs could not be diagnosed; out/fleet.json "
        "says why.\n"
    )
    rows = json.loads(Path("out/fleet.json").read_text())["rigs"]
    failed = {row["rig"]: row for row in rows if row["verdict"] == "failed"}
    assert set(failed) == {f"{kind}-1" for kind in kinds}
    assert len(rows) == 5 + len(kinds)
    assert [row["verdict"] for row in rows[-len(kinds) :]] == ["failed"] * len(kinds)
    if "broken" in kinds:
        assert failed["broken-1"]["error"] == (
            "A fault of ours, ZeroDivisionError: division by zero; diagnose this rig alone with "
            "--debug for the traceback."
        )


@pytest.mark.slow
def test_a_resumed_fleet_does_what_is_left_and_what_has_changed(here):
    campaign(here / "rigs" / "faulty-1")
    words = ["diagnose", "rigs", "--out", "out", "--workers", "2", "--quiet"]
    assert main(words) == 2
    before = json.loads(Path("out/fleet.json").read_text())["rigs"]
    Path("rigs/no_gap-1/run.csv").write_text("t,phi1\n0,0\n")  # other data
    assert main([*words, "--resume"]) == 2
    assert begun(here) == {
        "explained-1": 1,
        "explained-2": 1,
        "faulty-1": 2,
        "no_gap-1": 2,
        "single-1": 1,
        "unknown-1": 1,
    }
    assert json.loads(Path("out/fleet.json").read_text())["rigs"] == before
    assert main(words) == 2, "without --resume all is done anew"
    assert set(begun(here).values()) == {2, 3}


@pytest.mark.slow
def test_another_seed_is_another_diagnosis(here):
    words = ["diagnose", "rigs", "--workers", "2", "--quiet"]
    assert main(words) == 0
    assert main([*words, "--resume", "--seed", "1"]) == 0
    assert set(begun(here).values()) == {2}


@pytest.mark.slow
def test_progress_is_told_over_all(here, capsys):
    assert main(["diagnose", "rigs", "--progress", "json", "--workers", "1"]) == 0
    said = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert said[0]["stage"] == "diagnosing rigs: 0 of 5"
    assert said[-1]["stage"] == "diagnosing rigs: 5 of 5"
    assert [each["part"] for each in said] == [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    (here / "rigs-diagnosis" / "pieces" / "no_gap-1.json").unlink()
    assert main(["diagnose", "rigs", "--progress", "json", "--workers", "1", "--resume"]) == 0
    said = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert [each["part"] for each in said] == [0.8, 1.0], "what was done before took no time"


def test_an_interrupted_fleet_says_how_to_go_on(here, monkeypatch, capsys):
    def interrupted(work, pieces, choice, *, folder):
        yield Ended(pieces[0], {})
        raise KeyboardInterrupt

    monkeypatch.setattr(fleet, "run_pieces", interrupted)
    assert main(["diagnose", "rigs"]) == 130
    assert capsys.readouterr().err == (
        "tp-jax: Interrupted; what is done is kept in rigs-diagnosis, and the same command with "
        "--resume goes on.\n"
    )


def test_the_executor_is_handed_on(here, monkeypatch, capsys):
    asked = []

    def ended(work, pieces, choice, *, folder):
        asked.append(choice)
        yield from (Ended(piece, fault=Fault("WorkerLost", "5 workers died")) for piece in pieces)

    monkeypatch.setattr(fleet, "run_pieces", ended)
    assert main(["diagnose", "rigs", "--executor", "slurm", "--workers", "40"]) == 1
    assert asked == [ExecutorChoice("slurm", 40)]
    assert capsys.readouterr().out.startswith("5 rigs: 5 failed\nexplained-1: A fault of ours,")
