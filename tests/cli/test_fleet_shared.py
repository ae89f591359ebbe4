"""tp-jax diagnose --shared: rigs that share an effect, by stand-ins for their diagnoses."""

import json
from pathlib import Path

import pytest

from tests.cli import stand_in_rig
from tests.cli.stand_in_rig import campaign
from tests.shared_rigs import fleet as rigs_that_share
from tests.shared_rigs import scores_of
from tp_jax.cli import fleet, main
from tp_jax.cli.diagnosed import SCREEN
from tp_jax.gap.shared.scores import write

NAMES = tuple(f"no_gap-{i}" for i in range(1, 6))


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """A folder `rigs` of five campaigns that share the effect `b`."""
    monkeypatch.setattr(fleet, "WORK", stand_in_rig.diagnose_rig)
    monkeypatch.chdir(tmp_path)
    scores = scores_of(rigs_that_share(0, n=len(NAMES), shared=(0, 0.5, 0, 0, 0, 0)))
    for name, each in zip(NAMES, scores, strict=True):
        write(campaign(tmp_path / "rigs" / name) / SCREEN, each)
    return tmp_path


def table() -> dict:
    return json.loads(Path("rigs-diagnosis/fleet.json").read_text(encoding="utf-8"))


def test_a_fleet_says_what_its_rigs_share(here, capsys):
    assert main(["diagnose", "rigs", "--shared", "--workers", "1"]) == 0
    told = capsys.readouterr().out
    assert "The 5 rigs share one effect.\n" in told
    assert "\nThe kind's effects: b, " in told
    shared = table()["shared"]
    assert shared["rigs"] == [f"rig-{i}" for i in range(1, 6)]
    (only,) = shared["effects"]
    assert (only["effect"], only["verdict"]) == ("b", "kind")
    page = Path("rigs-diagnosis/fleet.html").read_text(encoding="utf-8")
    assert "<h3>The kind&#39;s effects</h3>" in page
    assert "<code>b</code>" in page


def test_nobody_asked_nothing_said(here, capsys):
    assert main(["diagnose", "rigs", "--workers", "1"]) == 0
    assert "share" not in capsys.readouterr().out
    assert "shared" not in table()
    assert "rigs share" not in Path("rigs-diagnosis/fleet.html").read_text(encoding="utf-8")


def test_it_can_be_asked_afterwards(here):
    assert main(["diagnose", "rigs", "--workers", "1", "--quiet"]) == 0
    (here / "rigs-diagnosis" / NAMES[0] / SCREEN).unlink()  # of an earlier version, say
    assert main(["diagnose", "rigs", "--workers", "1", "--quiet", "--shared", "--resume"]) == 0
    assert len(table()["shared"]["rigs"]) == 5
    begun = [len((here / "rigs" / name / "begun.txt").read_text().split()) for name in NAMES]
    assert begun == [2, 1, 1, 1, 1]


def test_rigs_without_scores_are_named(here):
    for name in NAMES[:2]:
        (here / "rigs" / name / SCREEN).unlink()
    campaign(here / "rigs" / "faulty-1")
    assert main(["diagnose", "rigs", "--shared", "--workers", "1", "--quiet"]) == 2
    shared = table()["shared"]
    assert sorted(shared["left_out"]) == ["faulty-1", *NAMES[:2]]
    assert len(shared["rigs"]) == 3


def test_two_rigs_share_nothing_that_could_be_known(here, capsys):
    words = [f"rigs/{name}" for name in NAMES[:2]]
    assert main(["diagnose", *words, "--out", "rigs-diagnosis", "--shared", "--workers", "1"]) == 0
    reason = (
        "Effects that rigs share need at least 3 rigs that could be diagnosed, and 2 were; add "
        "campaigns."
    )
    assert reason in capsys.readouterr().out
    assert table()["shared"]["reason"] == reason
    assert reason in Path("rigs-diagnosis/fleet.html").read_text(encoding="utf-8")


def test_one_campaign_shares_with_nobody(here, capsys):
    assert main(["diagnose", f"rigs/{NAMES[0]}", "--shared"]) == 2
    assert capsys.readouterr().err == (
        "tp-jax: --shared asks a fleet; give several campaigns, or a folder of them.\n"
    )
