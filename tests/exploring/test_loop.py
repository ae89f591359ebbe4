"""The loop, with the virtual rig's recordings and a diagnosis that is made up."""

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.waiting import until
from tp_jax.acquisition.campaign_entry import entries_of
from tp_jax.acquisition.port import Port
from tp_jax.acquisition.recorder import record
from tp_jax.acquisition.run_log import Settings
from tp_jax.errors import InputError, Notice
from tp_jax.exploring import explore, state
from tp_jax.exploring.amplitudes import announced_amplitude
from tp_jax.exploring.loop import _made_run
from tp_jax.gap.next_run import Finding, Forecast, Limits, Run
from tp_jax.recordings import load_campaign
from tp_jax.rig.emulator import Firmware
from tp_jax.rig.serve import Emulator
from tp_jax.rig.simulator import VirtualRig

ROOT = Path(__file__).parents[2]
DURATION = 1.0
FORECASTS = (
    Forecast(Run(omega=9.0), 0.5, {"b": 4.0}),
    Forecast(Run(omega=14.0), 2.0, {"b": 8.0}),
    Forecast(Run(release=0.4), 0.4, {"b": 3.5}),
)


@pytest.fixture(scope="module")
def rig():
    """The virtual rig, as fast as it is read."""
    firmware = Firmware(VirtualRig(effects={"contact_stribeck": 0.5}, seed=1), rate=250.0)
    with Emulator(firmware, speed=None) as emulator:
        yield emulator.port


class Lab:
    """What `explore` is handed: a rig that records, and a diagnosis that is sure after some runs.

    recorded, diagnosed: what it was asked for.
    """

    def __init__(self, port, sure_after=3, forecasts=FORECASTS):
        self.port, self.sure_after, self.forecasts = port, sure_after, forecasts
        self.recorded, self.diagnosed, self.told = [], [], []

    def record(self, run, out):
        self.recorded.append(run)
        settings = Settings(DURATION, run.omega, None, run.release, real_time=False)
        return record(Port(self.port, 460800), out, settings)

    def diagnose(self, folder):
        n = len(load_campaign(folder).recordings)
        self.diagnosed.append(n)
        p = 0.97 if n >= self.sure_after else 0.5
        return Finding("explained", (("a", p),), "a", p, {"b": 1.0 - p}, self.forecasts)

    def explore(self, folder, limits=Limits(1.0), **options):  # noqa: B008
        options = {"most": 6, "duration": DURATION, **options}
        return explore(
            folder,
            self.record,
            self.diagnose,
            limits=limits,
            diagnosed=lambda *told: self.told.append(told),
            **options,
        )


def files(folder):
    """Every recording with its bytes."""
    return {each.name: each.read_bytes() for each in folder.glob("*.csv")}


def test_it_goes_on_until_the_cause_is_known(rig, tmp_path):
    lab, folder = Lab(rig), tmp_path / "rig"
    explored = lab.explore(folder)
    assert explored.stop.reason == "cause"
    assert lab.recorded == [Run(release=0.45), Run(omega=9.0), Run(omega=9.0)]
    assert lab.diagnosed == [1, 2, 3]
    assert [told[:2] for told in lab.told] == list(zip(explored.runs, [1, 2, 3], strict=True))
    campaign = load_campaign(folder)
    assert [each.name for each in campaign.recordings] == ["decay.csv", "run-9.csv", "run-9-2.csv"]
    assert announced_amplitude(folder) == pytest.approx(0.18, abs=0.02)

    result = explored.to_dict()
    assert result["schema"] == "tp-jax/explore/1"
    assert result["stopped"] == "cause"
    assert result["causes"] == [{"effect": "a", "probability": 0.97}]
    assert [run["file"] for run in result["runs"]] == [r.name for r in campaign.recordings]
    assert [run["probability"] for run in result["runs"]] == [0.5, 0.5, 0.97]
    assert result["runs"][1]["expected_log_evidence"] == {"b": 4.0}
    assert result["runs"][1]["predicted_largest"] == 0.5
    json.dumps(result, allow_nan=False)

    # the same again: nothing is recorded or diagnosed, and the answer is the same
    before = files(folder)
    again = Lab(rig)
    assert again.explore(folder).to_dict() == result
    assert (again.recorded, again.diagnosed) == ([], [])
    assert files(folder) == before


def test_a_corrected_campaign_is_diagnosed_again(rig, tmp_path):
    folder = tmp_path / "rig"
    Lab(rig).explore(folder)
    toml = folder / "campaign.toml"
    toml.write_text(toml.read_text().replace("[rig]\n", "[rig]\nB1 = 1.2e-3\n"))
    lab = Lab(rig)
    lab.explore(folder)
    assert lab.diagnosed == [3]


def test_runs_are_what_the_campaign_says(rig, tmp_path):
    """In whatever unit: a run that was driven is neither a decay nor one at another frequency."""
    folder = tmp_path / "rig"
    Lab(rig).explore(folder, most=2, limits=Limits(1.0))
    toml = folder / "campaign.toml"
    text = toml.read_text()
    for said in ("frequency = 2.0", 'omega = 2.0\nunit = "Hz"', "period = 0.5"):
        toml.write_text(text.replace("omega = 9.0", said))
        decay, driven = map(_made_run, entries_of(folder))
        assert decay == Run(release=0.45)
        assert driven == Run(omega=pytest.approx(4.0 * np.pi))
    measured = dataclasses.replace(entries_of(folder)[1], omega=None, measured_drive=True)
    assert _made_run(measured) == Run()


def test_recordings_stay_within_the_limit(rig, tmp_path):
    Lab(rig).explore(tmp_path / "rig", Limits(0.3), most=1)
    (recording,) = load_campaign(tmp_path / "rig").recordings
    assert np.abs(recording.phi1).max() < 0.3


def test_a_limit_that_no_run_keeps_ends_it(rig, tmp_path):
    explored = Lab(rig).explore(tmp_path / "rig", Limits(0.3))
    assert explored.stop.reason == "indistinguishable"
    assert len(explored.runs) == 1
    # a wider limit goes on from there, without another diagnosis of the same recordings
    lab = Lab(rig)
    assert lab.explore(tmp_path / "rig", Limits(1.0)).stop.reason == "cause"
    assert lab.diagnosed == [2, 3]


def test_it_ends_with_the_runs_asked_for(rig, tmp_path):
    lab = Lab(rig, sure_after=9)
    assert lab.explore(tmp_path / "rig", most=2).stop.reason == "runs"
    assert lab.explore(tmp_path / "rig", most=3).stop.reason == "runs"
    assert lab.diagnosed == [1, 2, 3]


def test_recordings_that_are_there_count(rig, tmp_path):
    folder = tmp_path / "rig"
    Lab(rig).explore(folder, most=2)
    (folder / state.FILE).unlink()
    before = files(folder)
    lab = Lab(rig)
    explored = lab.explore(folder)
    assert lab.told[0][:2] == (None, 2)
    assert lab.diagnosed == [2, 3]
    assert len(explored.runs) == 1
    assert before.items() < files(folder).items()


def test_other_wishes_ask_for_another_diagnosis(rig, tmp_path):
    lab = Lab(rig)
    lab.explore(tmp_path / "rig", most=1)
    lab.explore(tmp_path / "rig", Limits(1.0, (5.0, 9.0)), most=1)
    assert lab.diagnosed == [1, 1]


def test_an_interrupted_diagnosis_is_made_again(rig, tmp_path):
    lab, folder = Lab(rig), tmp_path / "rig"
    good = lab.diagnose

    def interrupted(folder):
        raise KeyboardInterrupt

    lab.diagnose = interrupted
    with pytest.raises(KeyboardInterrupt):
        lab.explore(folder)
    before = files(folder)
    lab.diagnose = good
    explored = lab.explore(folder)
    assert lab.diagnosed == [1, 2, 3]
    assert [made.file for made in explored.runs] == ["decay.csv", "run-9.csv", "run-9-2.csv"]
    assert before.items() < files(folder).items()


@pytest.mark.parametrize("which", [1, 2, 3])
def test_the_second_recording_need_not_be_diagnosable(which, rig, tmp_path):
    """The first has to be, or nothing can be predicted, and later ones as well."""
    lab, folder = Lab(rig, sure_after=4), tmp_path / "rig"
    good = lab.diagnose

    def fails(folder):
        if len(load_campaign(folder).recordings) == which:
            raise InputError("It cannot be integrated.")
        return good(folder)

    lab.diagnose = fails
    if which == 2:
        with pytest.warns(Notice, match="The 2 recordings so far cannot be diagnosed"):
            assert lab.explore(folder).stop.reason == "cause"
        assert lab.diagnosed == [1, 3, 4]
    else:
        with pytest.raises(InputError, match="cannot be integrated"):
            lab.explore(folder)
        assert len(lab.recorded) == which


def test_forecasts_for_other_wishes_do_not_stand(rig, tmp_path):
    lab, folder = Lab(rig, sure_after=4), tmp_path / "rig"
    lab.explore(folder, most=1, amplitude=0.1)
    good = lab.diagnose

    def fails(folder):
        raise InputError("It cannot be integrated.")

    lab.diagnose = fails
    with pytest.raises(InputError, match="cannot be integrated"):
        lab.explore(folder, amplitude=0.5)
    lab.diagnose = good
    assert len(lab.recorded) == 1


def test_an_interrupted_recording_is_kept(rig, tmp_path):
    lab, folder = Lab(rig), tmp_path / "rig"
    good = lab.record
    lab.record = lambda run, out: dataclasses.replace(good(run, out), state="interrupted")
    with pytest.raises(KeyboardInterrupt):
        lab.explore(folder)
    lab.record = good
    assert lab.explore(folder).runs[0].file == "decay.csv"
    assert len(lab.recorded) == 3


def test_a_recording_that_cannot_be_used_is_kept_beside_the_campaign(rig, tmp_path):
    lab, folder = Lab(rig), tmp_path / "rig"
    good = lab.record
    lab.record = lambda run, out: good(Run(), out)  # the column stands still
    with pytest.raises(InputError, match=r"decay\.csv was recorded, but not added to"):
        lab.explore(folder)
    kept = (folder / "decay.csv").read_bytes()
    lab.record = good
    assert lab.explore(folder).runs[0].file == "decay-2.csv"
    assert (folder / "decay.csv").read_bytes() == kept


KILLED = """
import sys, time
from pathlib import Path
from tests.exploring.test_loop import Lab
lab = Lab(sys.argv[2], sure_after=9)
good = lab.diagnose
def slow(folder):
    print("diagnosing", flush=True)
    time.sleep(float(sys.argv[3]))
    return good(folder)
lab.diagnose = slow
lab.explore(Path(sys.argv[1]))
"""


@pytest.mark.parametrize("when", ["recording", "diagnosing"])
def test_killed_at_any_moment(when, tmp_path):
    """Nothing that was recorded is lost or written over, and the next call goes on."""
    firmware = Firmware(VirtualRig(seed=1), rate=250.0)
    folder = tmp_path / "rig"
    with Emulator(firmware, speed=None if when == "diagnosing" else 0.02) as emulator:
        sleep = "60" if when == "diagnosing" else "0"
        child = subprocess.Popen(
            [sys.executable, "-c", KILLED, str(folder), emulator.port, sleep],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            if when == "diagnosing":
                assert child.stdout.readline() == "diagnosing\n"
            else:
                until(lambda: (folder / "decay.csv").exists())
            before = files(folder)
        finally:
            child.kill()
            child.wait()
            child.stdout.close()
    with Emulator(firmware, speed=None) as emulator:
        lab = Lab(emulator.port)
        explored = lab.explore(folder)
    assert explored.stop.reason == "cause"
    named = [made.file for made in explored.runs]
    assert named == [each.name for each in load_campaign(folder).recordings]
    assert named[0] == ("decay.csv" if when == "diagnosing" else "decay-2.csv")
    if when == "diagnosing":
        assert before.items() < files(folder).items()


def test_a_killed_one_knows_the_run_that_was_added_already(rig, tmp_path):
    """Between the entry in campaign.toml and the state."""
    lab, folder = Lab(rig), tmp_path / "rig"
    lab.explore(folder, most=2)
    known = state.read(folder)
    planned = dataclasses.replace(known.runs[-1], verdict=None, first=None, probability=None)
    cut_off = dataclasses.replace(known, runs=known.runs[:1], next=planned)
    state.write(folder, cut_off)
    explored = lab.explore(folder)
    assert [made.file for made in explored.runs] == ["decay.csv", "run-9.csv", "run-9-2.csv"]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("{", "is not JSON"),
        ("{}", "is not the state of an exploration"),
        ('{"schema": "tp-jax/explore-state/2"}', "move it away"),
        ('{"schema": "tp-jax/explore-state/1", "runs": 3}', "runs must be a list of runs"),
    ],
)
def test_a_state_that_cannot_be_read_is_told(text, part, tmp_path):
    (tmp_path / state.FILE).write_text(text)
    with pytest.raises(InputError, match=part):
        state.read(tmp_path)


def test_the_state_comes_back_as_it_was(tmp_path):
    made = state.Made("a.csv", Run(omega=3.0), FORECASTS[0], "unknown", "a", 0.5)
    finding = Finding("unknown", (("a", 0.5),), "a", 0.5, {"b": 0.5}, FORECASTS)
    whole = state.State((made,), state.Made("b.csv", Run(release=0.5)), finding, {"files": ["a"]})
    state.write(tmp_path, whole)
    assert state.read(tmp_path) == whole
    assert [each.name for each in tmp_path.iterdir()] == [state.FILE]
    assert state.read(tmp_path / "new") == state.State()
