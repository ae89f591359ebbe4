"""tp-jax record and tp-jax rig serve."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.acquisition.swing import emulated
from tests.waiting import PATIENCE, running, until
from tp_jax.acquisition.device import Device
from tp_jax.acquisition.recorder import MAY_STILL_RUN
from tp_jax.acquisition.run_log import Status
from tp_jax.cli import main
from tp_jax.cli.live import live, plot, screen
from tp_jax.recordings import load_campaign, read_columns

ROOT = Path(__file__).parents[2]
FAST = ["record", "--port", "emulator", "--speed", "max"]


def test_a_run_of_the_virtual_rig(tmp_path, capsys):
    out, meta = tmp_path / "run.csv", tmp_path / "result.json"
    argv = [*FAST, "--duration", "2", "--omega", "13.09", "--effect", "contact_stribeck=0.5"]
    assert main([*argv, "--out", str(out), "--json", str(meta)]) == 0
    told = capsys.readouterr()
    assert told.out == f"Wrote {out}: 2001 samples in 2 s, 0 lost, 0 corrupt frames\n"
    assert told.err == ""
    assert out.read_text().startswith("t,phi1,phi2\n0,")
    assert read_columns(out).values["t"].size == 2001
    beside = json.loads(Path(f"{out}.meta.json").read_text())
    assert beside == json.loads(meta.read_text())
    assert beside["drive"]["omega"] == 13.09
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        "result.json",
        "run.csv",
        "run.csv.meta.json",
    ]

    # the same again: refused, and the file is as it was
    before = out.read_bytes()
    assert main([*argv, "--out", str(out)]) == 2
    assert capsys.readouterr().err.startswith(f"tp-jax: There is a file {out} already")
    assert out.read_bytes() == before

    # in another folder, under the same name: the same numbers
    other = tmp_path / "other" / "run.csv"
    assert main([*argv, "--out", str(other), "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert other.read_bytes() == before
    assert main([*argv, "--out", str(tmp_path / "b.csv"), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["samples"]["written"] == 2001
    assert (tmp_path / "b.csv").read_bytes() != before  # another run has other noise


@pytest.mark.parametrize("told", [["--quiet"], ["--json", "-"], []])
def test_a_motor_that_may_still_run_is_told_in_any_case(told, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Device, "stop", lambda _: False)
    argv = [*FAST, "--duration", "1", "--omega", "13.09", "--out", str(tmp_path / "r.csv")]
    assert main([*argv, *told]) == 2
    assert capsys.readouterr().err == f"tp-jax: {MAY_STILL_RUN}\n"


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_a_terminal_that_is_closed_does_not_end_the_bookkeeping():
    master, slave = os.openpty()
    with os.fdopen(slave, "w") as gone, contextlib.redirect_stderr(gone):
        with live(quiet=False) as progress:
            os.close(master)
            progress(Status(1.0, 2.0, None, 10, 0, 0, False, ("t",), np.zeros((0, 1))))
        os.dup2(os.open(os.devnull, os.O_WRONLY), slave)


def test_a_campaign(tmp_path, capsys):
    folder = tmp_path / "rig 3"
    argv = [*FAST, "--duration", "2", "--rate", "250", "--campaign", str(folder)]
    for run in (["--omega", "13.09"], ["--omega", "10"], ["--release", "0.6"], ["--omega", "10"]):
        assert main([*argv, *run]) == 0
    assert "Added it to" in capsys.readouterr().out
    campaign = load_campaign(folder)
    assert campaign.name == "rig 3"
    assert [each.name for each in campaign.recordings] == [
        "run-13.09.csv",
        "run-10.csv",
        "decay.csv",
        "run-10-2.csv",
    ]
    assert [each.omega for each in campaign.recordings] == [13.09, 10.0, None, 10.0]
    decay = campaign.recordings[2]
    assert decay.phi1[0] == pytest.approx(0.6, abs=0.006)
    first, again = (campaign.recordings[i].phi1 for i in (1, 3))
    assert not np.array_equal(first, again)  # repeated, not copied


def test_what_would_spoil_a_campaign_is_kept_beside_it(tmp_path, capsys):
    folder = tmp_path / "rig"
    argv = [*FAST, "--duration", "1", "--campaign", str(folder)]
    assert main([*argv, "--omega", "10", "--quiet"]) == 0
    before = (folder / "campaign.toml").read_bytes()
    capsys.readouterr()
    for more, part in (
        (["--omega", "9", "--rate", "500"], "sample_rate is 1000"),
        ([], "not move"),
    ):
        assert main([*argv, *more, "--quiet"]) == 2
        told = capsys.readouterr()
        assert told.out == ""
        assert told.err.startswith(f"tp-jax: Not added to the campaign {folder}: ")
        assert part in told.err
    assert (folder / "campaign.toml").read_bytes() == before
    assert {"run-9.csv", "decay.csv"} < {each.name for each in folder.iterdir()}
    assert len(load_campaign(folder).recordings) == 1


def test_a_calibration_of_ones_own(tmp_path):
    calibration = tmp_path / "rig.toml"
    calibration.write_text(
        '[phi1]\nlaw = "sine"\noffset = 1.652\ngain = 2.61\nerrors = { gain = 0.02 }\n'
        '[phi2]\nlaw = "line"\noffset = 1.641\ngain = 2.55\n'
    )
    out = tmp_path / "run.csv"
    argv = [*FAST, "--duration", "0.5", "--release", "0.3", "--calibration", str(calibration)]
    assert main([*argv, "--out", str(out), "--quiet"]) == 0
    meta = json.loads(Path(f"{out}.meta.json").read_text())
    assert meta["calibration"]["source"] == str(calibration)
    assert meta["calibration"]["phi1"]["law"] == "sine"
    largest = meta["calibration"]["phi1"]["standard_error"]["largest"]
    assert largest == pytest.approx(0.3 * 0.02 / 2.61, rel=0.3)


@pytest.mark.parametrize(
    ("argv", "part"),
    [
        (["record", "--duration", "1", "--out", "a.csv"], "--port"),
        (["record", "--port", "emulator", "--out", "a.csv"], "--duration"),
        ([*FAST, "--duration", "1"], "--out"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--campaign", "b"], "--campaign"),
        ([*FAST, "--duration", "0", "--out", "a.csv"], "--duration must be above zero"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--omega", "1", "--release", "1"], "--rel"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--omega", "0"], "--omega must be above"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--effect", "tilt"], "ID=SIZE"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--effect", "a=b"], "must give a a number"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--effect", "nothing=1"], "nothing"),
        (
            [*FAST, "--duration", "1", "--out", "a.csv", "--effect", "contact_stribek=1"],
            "did you mean contact_stribeck?",
        ),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--release", "1.6"], "within ±1.57"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--omega", "9999"], "drive at 9999"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--corrupt", "1"], "below 1"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--unplug", "1"], "AT:FOR"),
        ([*FAST, "--duration", "1", "--out", "a.csv", "--calibration", "no.toml"], "no.toml"),
        ([*FAST, "--duration", "1", "--out", "."], "already"),
        (["record", "--port", "no", "--duration", "1", "--out", "a.csv"], "Cannot open the port"),
        (
            ["record", "--port", "no", "--duration", "1", "--out", "a.csv", "--rate", "250"],
            "--rate",
        ),
        (
            ["record", "--port", "no", "--duration", "1", "--out", "a.csv", "--effect", "a=1"],
            "--eff",
        ),
        (["rig"], "COMMAND"),
        (["rig", "serve", "--omega", "3"], "for --text"),
        (["rig", "serve", "--speed", "0"], "--speed must be above zero"),
    ],
)
def test_faults_are_told_in_one_sentence(argv, part, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    assert main(argv) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("tp-jax: ")
    assert told.err.count("\n") == 1
    assert part in told.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [["record"], ["rig"], ["rig", "serve"], ["calibrate"]])
def test_help_loads_nothing_heavy(command):
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "tp_jax", *command, "--help"],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.split("\n")}
    assert "tp_jax" in loaded
    assert loaded.isdisjoint({"jax", "numpy", "scipy", "rich", "serial"})


def test_a_recording_cut_short_is_kept_and_told(tmp_path, capsys):
    folder = tmp_path / "rig"
    with emulated(speed=1.0, unplug=(0.5, 1e9)) as rig:
        argv = ["record", "--port", rig.port, "--duration", "5", "--omega", "10"]
        assert main([*argv, "--campaign", str(folder), "--reconnect", "0.3"]) == 2
    told = capsys.readouterr()
    assert "unplugged and did not come back" in told.err
    assert "Added it to" in told.out
    assert load_campaign(folder).recordings[0].duration == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("impatient", [False, True])
def test_interrupting(impatient, tmp_path):
    out = tmp_path / "run.csv"
    words = [sys.executable, "-m", "tp_jax", "record", "--port", "emulator"]
    with running(
        [*words, "--duration", "60", "--omega", "10", "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    ) as child:
        until(lambda: child.poll() is not None or (out.exists() and out.stat().st_size > 1000))
        assert child.poll() is None
        child.send_signal(signal.SIGINT)
        if impatient:
            time.sleep(0.01)
            child.send_signal(signal.SIGINT)
        told, fault = child.communicate(timeout=PATIENCE)
    assert child.returncode == 130
    assert told.startswith(f"Wrote {out}: ")
    assert fault == "tp-jax: interrupted.\n"
    assert json.loads(Path(f"{out}.meta.json").read_text())["state"] == "interrupted"


@pytest.mark.parametrize("end", ["interrupt", "terminate", "stdin"])
def test_serving(end, tmp_path):
    words = [sys.executable, "-m", "tp_jax", "rig", "serve", "--seed", "3", "--speed", "5"]
    words += ["--until-stdin-closes"] if end == "stdin" else []
    pipes = dict(stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    with running(words, cwd=ROOT, **pipes) as rig:
        port = rig.stdout.readline().strip()
        assert Path(port).is_symlink()
        for name in ("a.csv", "b.csv"):  # one host after the other
            argv = ["record", "--port", port, "--duration", "1", "--omega", "10", "--quiet"]
            assert main([*argv, "--out", str(tmp_path / name)]) == 0
        if end == "stdin":
            rig.stdin.close()
        else:
            rig.send_signal(signal.SIGINT if end == "interrupt" else signal.SIGTERM)
        assert rig.wait(PATIENCE) == 0
    assert not Path(port).parent.exists()


# What is shown -------------------------------------------------------------------------------


def test_the_screen():
    t = np.arange(0.0, 4.0, 1e-3)
    status = Status(
        t=4.0,
        duration=60.0,
        rate=998.7,
        written=4000,
        lost=3,
        corrupt=2,
        unplugged=True,
        names=("t", "phi1"),
        recent=np.column_stack([t, np.sin(t)]),
    )
    lines = screen(status, 40).split("\n")
    assert lines[0] == (
        "4.0 of 60 s  999 Hz  4000 samples  3 lost  2 corrupt  unplugged, waiting for it"
    )
    assert lines[1] == "phi1 [rad]"
    assert len(lines) == 2 + 6
    assert lines[2].endswith("+1.000")
    assert lines[-1].endswith("-0.756")


def test_a_plot():
    t = np.array([0.0, 1.0, 2.0, 3.0])
    assert plot(t, np.array([0.0, 1.0, 2.0, 3.0]), width=2, height=1) == "⡠⠊ +3.000 +0.000"
    assert plot(t[:1], t[:1], width=2, height=1).count("⠁") == 1
