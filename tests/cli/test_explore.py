"""tp-jax explore: options, what it prints, and who is asked to set the rig."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.acquisition.swing import emulated
from tp_jax.cli import explore, main
from tp_jax.gap.next_run import Finding, Forecast, Run
from tp_jax.recordings import load_campaign

ROOT = Path(__file__).parents[2]
FAST = ["explore", "--port", "emulator", "--speed", "max", "--rate", "250", "--duration", "1"]


@pytest.fixture
def _made_up(monkeypatch):
    """A diagnosis that is sure after two runs."""

    def diagnoser(args, limits):
        def diagnose(folder):
            n = len(load_campaign(folder).recordings)
            p = 0.97 if n >= 2 else 0.5
            forecast = Forecast(Run(omega=9.0), 0.5, {"b": 4.0})
            return Finding("explained", (("a", p),), "a", p, {"b": 1.0 - p}, (forecast,))

        return diagnose

    monkeypatch.setattr(explore, "_diagnoser", diagnoser)


@pytest.mark.usefixtures("_made_up")
def test_rounds_and_result(tmp_path, capsys):
    folder, result = tmp_path / "rig", tmp_path / "result.json"
    argv = [*FAST, "--campaign", str(folder), "--json", str(result)]
    assert main([*argv, "--effect", "contact_stribeck=0.5"]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.splitlines() == [
        "Run 1, decay.csv, decay from 0.6 rad: first cause a, probability 0.5",
        "Run 2, run-9.csv, drive at 9 rad/s: first cause a, probability 0.97",
        "The cause is a, with probability 0.97.",
        f"Report: {folder / 'diagnosis' / 'report.html'}",
    ]
    content = json.loads(result.read_text())
    assert content["schema"] == "tp-jax/explore/1"
    assert [run["omega"] for run in content["runs"]] == [None, 9.0]
    assert [r.omega for r in load_campaign(folder).recordings] == [None, 9.0]

    # again: the result alone on standard output
    assert main([*argv[:-1], "-"]) == 0
    assert json.loads(capsys.readouterr().out) == content
    assert main([*argv, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


@pytest.mark.usefixtures("_made_up")
def test_a_folder_is_made_where_none_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    (tmp_path / "exploration").mkdir()
    assert main([*FAST, "--runs", "1"]) == 0
    assert capsys.readouterr().out.startswith("Recordings go to exploration-2.\n")
    assert (tmp_path / "exploration-2" / "decay.csv").is_file()


@pytest.mark.usefixtures("_made_up")
def test_a_campaign_has_one_amplitude(tmp_path, capsys):
    argv = [*FAST, "--campaign", str(tmp_path / "rig")]
    assert main([*argv, "--amplitude", "0.1"]) == 0
    capsys.readouterr()
    assert main([*argv, "--amplitude", "0.5"]) == 2
    assert "was driven at 0.1 rad" in capsys.readouterr().err


@pytest.mark.usefixtures("_made_up")
def test_driven_runs_alone(tmp_path):
    folder = tmp_path / "rig"
    argv = [*FAST, "--campaign", str(folder), "--no-release", "--omega", "6:12", "--quiet"]
    assert main(argv) == 0
    assert [r.omega for r in load_campaign(folder).recordings] == [6.0, 9.0]


@pytest.mark.usefixtures("_made_up")
def test_a_rig_that_takes_commands_drives_itself(tmp_path, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr("builtins.input", lambda: asked.append(1))
    with emulated(rate=250.0) as rig:
        argv = ["explore", "--port", rig.port, "--duration", "1", "--campaign", str(tmp_path / "a")]
        assert main([*argv, "--quiet"]) == 0
    # a hand has to let the column go, the motor hears the program
    assert len(asked) == 1
    said = capsys.readouterr().err
    assert said == (
        "With the motor at rest, hold the column at 0.6 rad, press Enter, and let it go.\n"
    )


@pytest.mark.usefixtures("_made_up")
@pytest.mark.parametrize("yes", [False, True])
def test_somebody_is_told_how_to_set_a_rig_without_commands(yes, tmp_path, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr("builtins.input", lambda: asked.append(1))
    with emulated(rate=250.0, text=True) as rig:
        argv = ["explore", "--port", rig.port, "--duration", "1", "--campaign", str(tmp_path / "a")]
        assert main([*argv, *(["--yes"] if yes else [])]) == 0
    assert len(asked) == (0 if yes else 2)
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 2
    assert said[0].startswith("With the motor at rest, hold the column at 0.6 rad")
    assert said[1].startswith("Set the motor to 9 rad/s (1.432 Hz)")
    assert [r.omega for r in load_campaign(tmp_path / "a").recordings] == [None, 9.0]


@pytest.mark.usefixtures("_made_up")
def test_nobody_at_the_rig_is_told(tmp_path, capsys, monkeypatch):
    def ended():
        raise EOFError

    monkeypatch.setattr("builtins.input", ended)
    with emulated(rate=250.0) as rig:
        argv = ["explore", "--port", rig.port, "--duration", "1", "--campaign", str(tmp_path / "a")]
        assert main(argv) == 2
    assert "add --yes" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "part"),
    [
        (["--omega", "9"], "MIN:MAX"),
        (["--omega", "9:6"], "must rise"),
        (["--omega", "0:6"], "above zero"),
        (["--limit", "0"], "--limit must be above zero"),
        (["--runs", "0"], "--runs"),
        (["--no-release"], "needs --omega"),
        (["--effect", "contact_stribek=1"], "did you mean contact_stribeck?"),
        (["--calibration", "no.toml"], "no.toml"),
        (["--port", "no"], "Cannot open the port"),
    ],
)
def test_faults_are_told_in_one_sentence(more, part, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    argv = FAST if "--port" not in more else ["explore"]
    assert main([*argv, "--campaign", "rig", *more]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("tp-jax: ")
    assert told.err.count("\n") == 1
    assert part in told.err


def test_help_loads_nothing_heavy():
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "tp_jax", "explore", "--help"],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.split("\n")}
    assert loaded.isdisjoint({"jax", "numpy", "scipy", "rich", "serial"})


def test_lines():
    assert explore.line(None, 1, Finding("no_gap")) == ("Recordings that are there, 1: no gap")
    assert explore.line(None, 2, Finding("unknown")).endswith("no cause is likely yet")
    assert "candidate a" in explore.line(None, 2, Finding("unknown", (), "a", 0.4))
