"""tp-jax sensitivity: arguments, what is written and printed; light until it runs."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import tp_jax
from tp_jax.cli import main

ROOT = Path(__file__).parent.parent.parent
HEAVY = {"jax", "numpy", "scipy", "SALib", "pandas", "matplotlib"}


@pytest.fixture
def called(monkeypatch):
    """What the library is called with; nothing is computed."""
    monkeypatch.setenv("TP_JAX_CACHE", "off")
    seen = {}

    def sensitivity(campaign, **options):
        seen.update(options, campaign=campaign)
        return SimpleNamespace(
            to_dict=lambda: {"schema": "tp-jax/sensitivity/1"}, summary=lambda: "A table."
        )

    monkeypatch.setitem(vars(tp_jax), "sensitivity", sensitivity)
    module = sys.modules.get("tp_jax.cli.sensitivity") or __import__(
        "tp_jax.cli.sensitivity", fromlist=["run"]
    )
    monkeypatch.setattr(module, "load", lambda args, path: SimpleNamespace(name=path, B1=None))
    return seen


def test_help_loads_nothing_heavy():
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "tp_jax", "sensitivity", "--help"],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.split("\n")}
    assert loaded.isdisjoint(HEAVY)
    assert "--out" in done.stdout


def test_arguments_reach_the_library(called, capsys):
    argv = ["sensitivity", "c", "--seed", "3", "--fix", "B1=2", "--spread", "1.5", "--samples"]
    assert main([*argv, "64", "--profile", "Tst", "--profile", "T0"]) == 0
    assert called["fix"] == {"B1": 2.0}
    assert (called["spread"], called["samples"], called["seed"]) == (1.5, 64, 3)
    assert called["profile"] == ("Tst", "T0")
    assert capsys.readouterr().out == "A table.\n"


@pytest.mark.usefixtures("called")
def test_json_alone(capsys):
    assert main(["sensitivity", "c", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["schema"] == "tp-jax/sensitivity/1"


@pytest.mark.usefixtures("called")
def test_quiet(capsys, tmp_path):
    path = tmp_path / "new" / "s.json"
    assert main(["--quiet", "sensitivity", "c", "--json", str(path)]) == 0
    assert capsys.readouterr().out == ""
    assert path.is_file()


@pytest.mark.parametrize(
    ("argv", "part"),
    [
        (["sensitivity"], "CAMPAIGN"),
        (["sensitivity", "c", "--samples", "0"], "--samples must be a whole number"),
        (["sensitivity", "c", "--spread", "wide"], "--spread must be a number"),
        (["sensitivity", "nowhere"], "nowhere"),
    ],
)
def test_faults(argv, part, capsys):
    assert main(argv) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert part in told.err
    assert told.err.count("\n") == 1
